"""Service client with synchronous and asynchronous calls."""

import threading
from typing import Optional

import rospy

from my_robot_package_interfaces.srv import AddTwoInts, AddTwoIntsRequest
from nodekit import (
    CallCancelled,
    CallError,
    CallFuture,
    FloatParameter,
    IntParameter,
    MultiThreadedExecutor,
    Node,
    ParameterSet,
    run,
)

#: Interval of log lines while there is no service [s]; from 1 s on, nodekit logs its own lines.
_WAIT_S = 0.9


class ServiceClientNodeParameters(ParameterSet):
    """Parameters of service_client_node."""

    a = IntParameter(2, help="the first number")
    b = IntParameter(3, help="the second number")
    period = FloatParameter(
        1.0, minimum=0.001, maximum=3600.0, unit="s", help="time between pairs of calls"
    )
    timeout = FloatParameter(5.0, minimum=0.001, maximum=3600.0, unit="s", help="timeout of a call")


class ServiceClientNode:
    """Requests the sum of two numbers repeatedly, asynchronously and synchronously.

    The synchronous call waits, in a thread of the executor. The answer of the asynchronous call is
    handled in the node's callback group, so after the callback that made the call.

    :ROS Clients:
        - ``add_two_ints`` (my_robot_package_interfaces/AddTwoInts)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ServiceClientNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._parameters = node.declare_parameters(ServiceClientNodeParameters)
        MultiThreadedExecutor(2).add_node(node)
        self._client = node.create_client("add_two_ints", AddTwoInts)
        self._has_found = False
        node.create_timer(lambda: 1.0 / self._parameters.values.period, self.send_requests)

    def send_requests(self, elapsed: float) -> None:
        """Wait for the service, the first time, then send both requests."""
        if self._wait_for_service():
            settings = self._parameters.values
            self.send_request_async(settings.a, settings.b)
            self.send_request(settings.a, settings.b)

    def _wait_for_service(self) -> bool:
        while self._node.is_up and not (self._has_found or rospy.is_shutdown()):
            self._has_found = self._client.wait_for_service(_WAIT_S)
            if self._node.is_up and not self._has_found:
                rospy.loginfo("Service not available, waiting again...")
        return self._has_found

    def send_request(self, a: int, b: int) -> Optional[int]:
        """Call, and wait for the answer.

        :param a: an int64
        :param b: an int64
        :returns: their sum, None without an answer
        """
        try:
            answer = self._client.call(AddTwoIntsRequest(a, b), self._parameters.values.timeout)
        except CallError as error:
            _log_failure(error)
            return None
        _log_result("synchronous", answer.sum)
        return int(answer.sum)

    def send_request_async(self, a: int, b: int) -> Optional[CallFuture]:
        """Call; :meth:`response_callback` receives the answer.

        :param a: an int64
        :param b: an int64
        :returns: the future answer, None if the request could not be sent
        """
        try:
            # A separate request for each call: a shared one might be changed while it is sent.
            request = AddTwoIntsRequest(a, b)
            timeout = self._parameters.values.timeout
            future = self._client.call_async(request, timeout)
        except CallError as error:
            _log_failure(error)
            return None
        future.add_done_callback(self.response_callback)
        return future

    def response_callback(self, future: CallFuture) -> None:
        """Log the answer."""
        try:
            _log_result("asynchronous", future.result().sum)
        except CallError as error:
            _log_failure(error)


def _log_result(how: str, total: int) -> None:
    rospy.loginfo("Result: %d (%s, %s)", total, how, threading.current_thread().name)


def _log_failure(error: CallError) -> None:
    if not isinstance(error, CallCancelled):  # cancelled by the node's shutdown
        rospy.logerr("Service call failed: %s", error)


def main() -> None:
    """Run the node until it is shut down."""
    run("service_client_node", ServiceClientNode)
