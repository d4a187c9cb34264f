"""Service bridge: discovers services, and bridges each as long as it exists."""

import threading
from typing import Any, Callable, Dict, Optional, Tuple, Union

import rospy
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.validate_full_topic_name import validate_full_topic_name

from nodekit import CallError, Node, ReentrantCallbackGroup, Throttle
from nodekit.master import MasterClient
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.call_bridge import CallBridge
from ros2_bridge.ros2.client import NoResponse, Ros2Client
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import (
    RESERVED_PACKAGES,
    Rules,
    Route,
    parameter_services,
    select_routes,
)
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.types.codec_ops import ConversionError
from ros2_bridge.types.service_types import ServiceTypes
from ros2_bridge.types.type_registry import ServiceType, TypeRegistry

#: Queue size for the requests and responses of a service.
_DEPTH = 1000
#: Fields that conventionally hold the reason of a failure.
_WHY = ("message", "status_message", "reason")
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 1.0


class ServiceToRos2:
    """ROS 1 service, offered in ROS 2.

    ROS 2 services cannot report errors. If a response has ``success`` and ``message``, an error is
    reported there; otherwise there is no response, as if the server had died, and a log line.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param owner: ROS 2 node that offers it
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the timeout of a call [s]
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        owner: Ros2Node,
        name: str,
        other: str,
        kind: ServiceType,
        timeout: Callable[[], float],
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self.owner = owner
        self.kind, self._timeout = kind, timeout
        self._end = participant.create_service(owner, kind.cls, other, self._answer, _DEPTH)
        self._scope = node.create_scope()
        self._client = self._scope.create_client(name, kind.raw, group=ReentrantCallbackGroup())

    def _answer(self, request: Any, send: Callable[[Any], None]) -> None:
        """Call the service in another thread, because this one is shared."""
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
        response = self.kind.cls.Response()
        fields = response.get_fields_and_field_types()
        reason = [name for name in _WHY if fields.get(name) == "string"]
        if fields.get("success") == "boolean" and reason:
            setattr(response, reason[0], why)
            send(response)
        else:
            if self._throttle.is_due():
                rospy.logwarn(f"a caller in ROS 2 gets no response: {why}")

    def close(self) -> None:
        """Stop offering the service."""
        self._end()
        self._scope.close()


class ServiceToRos1:
    """ROS 2 service, offered in ROS 1; without a response in time the caller gets an error.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the timeout of a call [s]

    :ivar server: ROS 1 name of the node that offers it, if known
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        name: str,
        other: str,
        kind: ServiceType,
        timeout: Callable[[], float],
    ) -> None:
        self.kind, self._timeout, self.server = kind, timeout, ""
        self._client = Ros2Client(participant, kind.cls, other, _DEPTH)
        self._scope = node.create_scope()
        self._scope.create_service(name, kind.raw, self._answer, group=ReentrantCallbackGroup())

    def _answer(self, request: Any) -> Any:
        try:
            cdr = self.kind.request.to_cdr(request._buff)
            asked = deserialize_message(cdr, self.kind.cls.Request)
            response = self._client.call(asked, self._timeout())
            raw = self.kind.raw._response_class()
            raw._buff = self.kind.response.to_ros1(serialize_message(response))
        except (NoResponse, ConversionError) as error:
            raise rospy.ServiceException(str(error)) from None
        return raw

    def close(self) -> None:
        """Stop offering the service."""
        self._scope.close()
        self._client.close()


_Pair = Union[ServiceToRos1, ServiceToRos2]


class ServiceBridge(CallBridge[_Pair]):
    """Pairs of services, created and closed as services appear and disappear.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param client: client of the master
    :param timeout: returns the timeout of a call [s]
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        client: MasterClient,
        types: TypeRegistry,
        skip_log: SkipLog,
        timeout: Callable[[], float],
    ) -> None:
        super().__init__(node, participant, types, skip_log, timeout)
        self._types1 = ServiceTypes(client)

    def update_services(
        self,
        rules: Rules,
        ros1: Ros1Graph,
        ros2: Dict[str, Tuple[str, str]],
        owners: Dict[str, Ros2Node],
    ) -> None:
        """Create and close pairs after a poll of both graphs.

        :param ros2: type and node of each ROS 2 service, by its ROS 1 name
        :param owners: the ROS 1 nodes that are shown in ROS 2
        """
        self._names, self._ros1, self._ros2, self._owners = rules.names, ros1, ros2, owners
        in_ros1 = set(ros1.services) - parameter_services(set(ros1.services))
        in_ros2 = {
            name for name, (kind, _) in ros2.items() if not kind.startswith(RESERVED_PACKAGES)
        }
        self._types1.begin_poll(in_ros1)
        # A name with servers in both ROSes is not bridged.
        self.update_pairs(select_routes(rules, in_ros1 - in_ros2, in_ros2 - in_ros1))
        for name, why in self._types1.unanswered().items():
            self._skip_log.report(f"{name} of ROS 1: its server does not answer ({why})")

    def servers(self) -> Dict[str, str]:
        """Return the current or last ROS 2 node of each service that is bridged to ROS 1.

        All names are ROS 1 names.
        """
        found = {}
        for route, pair in self.pairs.items():
            if isinstance(pair, ServiceToRos1):
                if route.name in self._ros2:
                    pair.server = self._ros2[route.name][1]
                found[route.name] = pair.server
        return found

    def _has_same_type(self, route: Route, pair: _Pair) -> bool:
        return self._type(route) in (None, pair.kind.ros1)

    def _is_as_begun(self, route: Route, pair: _Pair) -> bool:
        """Return whether a pair is offered by the right node, which may have appeared later."""
        return isinstance(pair, ServiceToRos1) or pair.owner is self._owner(route)

    def _begin(self, route: Route) -> Optional[_Pair]:
        name, other = route.name, self._names.in_ros2(route.name) or route.name
        validate_full_topic_name(other, is_service=True)
        kind = self._type(route)
        if kind is None or kind.startswith(RESERVED_PACKAGES):
            return None
        found, node, participant = self._types.service(kind), self._node, self._participant
        if route.to_ros2:
            return ServiceToRos2(
                node, participant, self._owner(route), name, other, found, self._timeout
            )
        return ServiceToRos1(node, participant, name, other, found, self._timeout)

    def _owner(self, route: Route) -> Ros2Node:
        """Return the node that offers a ROS 1 service in ROS 2."""
        return self._owner_of(self._ros1.services.get(route.name, ""))

    def _type(self, route: Route) -> Optional[str]:
        """Return the ROS 1 name of a service's type; None if it is not known yet."""
        if route.to_ros2:
            return self._types1.of(route.name)
        return self._types.ros1_name(self._ros2[route.name][0])
