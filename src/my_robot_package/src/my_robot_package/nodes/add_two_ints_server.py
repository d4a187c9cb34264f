"""Service that adds two numbers."""

import threading
import time

import rospy

from my_robot_package_interfaces.srv import (
    AddTwoInts,
    AddTwoIntsRequest,
    AddTwoIntsResponse,
)
from nodekit import (
    FloatParameter,
    IntParameter,
    MultiThreadedExecutor,
    Node,
    ParameterSet,
    ReentrantCallbackGroup,
    read_once,
    run,
)

#: Range of an int64.
INT64_MIN, INT64_MAX = -(2**63), 2**63 - 1


class AddTwoIntsServerParameters(ParameterSet):
    """Parameters of add_two_ints_server."""

    delay = FloatParameter(0.0, minimum=0.0, maximum=3600.0, unit="s", help="duration of each call")
    threads = read_once(IntParameter(4, minimum=1, maximum=100, help="calls answered in parallel"))


def add(a: int, b: int) -> int:
    """Return the sum of two numbers.

    :param a: an int64
    :param b: an int64
    :raises OverflowError: if the sum is not an int64
    """
    total = a + b
    if not INT64_MIN <= total <= INT64_MAX:
        raise OverflowError(
            f"{a} + {b} is {total}: must be in [{INT64_MIN}, {INT64_MAX}], which an int64 holds"
        )
    return total


class AddTwoIntsServer:
    """Adds two integers; the caller gets an error if the sum does not fit into an int64.

    :ROS Services:
        - ``add_two_ints`` (my_robot_package_interfaces/AddTwoInts)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`AddTwoIntsServerParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(AddTwoIntsServerParameters)
        MultiThreadedExecutor(self._parameters.values.threads).add_node(node)
        group = ReentrantCallbackGroup()
        node.create_service("add_two_ints", AddTwoInts, self.add_two_ints, group=group)

    def add_two_ints(self, request: AddTwoIntsRequest) -> AddTwoIntsResponse:
        """Answer with the sum."""
        thread = threading.current_thread().name
        rospy.loginfo("Incoming request: a=%d, b=%d (%s)", request.a, request.b, thread)
        time.sleep(self._parameters.values.delay)
        try:
            return AddTwoIntsResponse(add(request.a, request.b))
        except OverflowError as error:
            raise rospy.ServiceException(str(error)) from None


def main() -> None:
    """Run the node until it is shut down."""
    run("add_two_ints_server", AddTwoIntsServer)
