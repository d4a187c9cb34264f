"""One service, one way."""

import threading
from typing import Any, Callable

import rospy
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message, serialize_message

from nodekit import CallError, Node
from ros2_bridge.ros2.ros2_client import NoAnswer, Ros2Client
from ros2_bridge.ros2.ros2_side import Ros2
from ros2_bridge.types.instructions import ConversionError
from ros2_bridge.types.types import ServiceType

#: Fields that say, by convention, why a service has failed.
_WHY = ("message", "status_message", "reason")


class ServiceToRos2:
    """A service of ROS 1, offered in ROS 2.

    ROS 2 has no errors of services. Where a response has ``success`` and ``message``, an error is
    reported there; otherwise there is no response, as where a server has died, and a line in the
    log.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param owner: node of ROS 2 that offers it
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the longest wait, s
    """

    def __init__(
        self,
        node: Node,
        side: Ros2,
        owner: Ros2Node,
        name: str,
        other: str,
        kind: ServiceType,
        timeout: Callable[[], float],
    ) -> None:
        self.owner = owner
        self.kind, self._timeout = kind, timeout
        self._end = side.serve(owner, kind.cls, other, self._answer)
        self._made = node.lifetime()
        self._client = self._made.client(name, kind.raw, group=node.group(exclusive=False))

    def _answer(self, request: Any, send: Callable[[Any], None]) -> None:
        """Have the service called in a thread of its own: this one is everybody's."""
        try:
            raw = self.kind.raw._request_class()
            raw._buff = self.kind.request.to_ros1(serialize_message(request))
            future = self._client.call_async(raw, self._timeout())
        except (CallError, ConversionError) as error:
            self._fail(send, str(error))
            return
        threading.Thread(target=self._wait, args=(future, send), daemon=True).start()

    def _wait(self, future: Any, send: Callable[[Any], None]) -> None:
        try:
            cdr = self.kind.response.to_cdr(future.result()._buff)
        except (CallError, ConversionError) as error:
            self._fail(send, str(error))
        else:
            send(deserialize_message(cdr, self.kind.cls.Response))

    def _fail(self, send: Callable[[Any], None], why: str) -> None:
        answer = self.kind.cls.Response()
        fields = answer.get_fields_and_field_types()
        reason = [name for name in _WHY if fields.get(name) == "string"]
        if fields.get("success") == "boolean" and reason:
            setattr(answer, reason[0], why)
            send(answer)
        else:
            rospy.logwarn_throttle(1.0, f"a caller in ROS 2 gets no response: {why}")

    def close(self) -> None:
        """End it."""
        self._end()
        self._made.close()


class ServiceToRos1:
    """A service of ROS 2, offered in ROS 1; without a response in time the caller gets an error.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the longest wait, s
    """

    def __init__(
        self,
        node: Node,
        side: Ros2,
        name: str,
        other: str,
        kind: ServiceType,
        timeout: Callable[[], float],
    ) -> None:
        self.kind, self._timeout = kind, timeout
        self._client = Ros2Client(side, kind.cls, other)
        self._made = node.lifetime()
        self._made.service(name, kind.raw, self._answer, group=node.group(exclusive=False))

    def _answer(self, request: Any) -> Any:
        try:
            cdr = self.kind.request.to_cdr(request._buff)
            asked = deserialize_message(cdr, self.kind.cls.Request)
            answer = self._client.call(asked, self._timeout())
            raw = self.kind.raw._response_class()
            raw._buff = self.kind.response.to_ros1(serialize_message(answer))
        except (NoAnswer, ConversionError) as error:
            raise rospy.ServiceException(str(error)) from None
        return raw

    def close(self) -> None:
        """End it."""
        self._made.close()
        self._client.close()
