"""Service bridge: discovers services, and bridges each until it is gone."""

import threading
from typing import Any, Callable, Dict, Optional, Tuple, Union

import rospy
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.validate_full_topic_name import validate_full_topic_name

from nodekit import CallError, Node, ReentrantCallbackGroup, Throttle
from nodekit.master import MasterClient
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.client import NoResponse, Ros2Client
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import OWN_WAYS, Rules, Way, parameter_services, wanted
from ros2_bridge.rules.active_pairs import PairBridge
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.types.codec_ops import ConversionError
from ros2_bridge.types.service_types import ServiceTypes
from ros2_bridge.types.type_registry import ServiceType, TypeRegistry

#: How many requests, and responses, of a service are kept in a burst.
_DEPTH = 1000
#: Fields that say, by convention, why a service has failed.
_WHY = ("message", "status_message", "reason")
#: Shortest time between two log lines of one kind [s].
_LOG_PERIOD_S = 1.0


class ServiceToRos2:
    """A service of ROS 1, offered in ROS 2.

    ROS 2 has no errors of services. Where a response has ``success`` and ``message``, an error is
    reported there; otherwise there is no response, as where a server has died, and a line in the
    log.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param owner: node of ROS 2 that offers it
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the longest wait [s]
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
        """Close it."""
        self._end()
        self._scope.close()


class ServiceToRos1:
    """A service of ROS 2, offered in ROS 1; without a response in time the caller gets an error.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the longest wait [s]

    :ivar server: name in ROS 1 of the node that offers it, as far as is known
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
        """Close it."""
        self._scope.close()
        self._client.close()


_Pair = Union[ServiceToRos1, ServiceToRos2]


class ServiceBridge(PairBridge[_Pair]):
    """Pairs of services, created and closed as both graphs require.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param client: asks the master
    :param timeout: returns the longest wait for a response [s]
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
        super().__init__(skip_log)
        self._node, self._participant, self._types, self._timeout = (
            node,
            participant,
            types,
            timeout,
        )
        self._types1 = ServiceTypes(client)

    def update_services(
        self,
        rules: Rules,
        ros1: Ros1Graph,
        ros2: Dict[str, Tuple[str, str]],
        owners: Dict[str, Ros2Node],
    ) -> None:
        """Begin and end what this poll of both graphs asks for.

        :param ros2: type and node of each service of ROS 2, by its name in ROS 1
        :param owners: the nodes of ROS 1 that appear in ROS 2
        """
        self._names, self._ros1, self._ros2, self._owners = rules.names, ros1, ros2, owners
        in_ros1 = set(ros1.services) - parameter_services(set(ros1.services))
        in_ros2 = {name for name, (kind, _) in ros2.items() if not kind.startswith(OWN_WAYS)}
        self._types1.begin_poll(in_ros1)
        # A name that both sides have is not called for the other.
        self.update_pairs(wanted(rules, in_ros1 - in_ros2, in_ros2 - in_ros1))

    def servers(self) -> Dict[str, str]:
        """Return the node of ROS 2 that offers each service, or did so until just now.

        By the names in ROS 1, of services that are bridged to there.
        """
        found = {}
        for way, pair in self.pairs.items():
            if isinstance(pair, ServiceToRos1):
                if way.name in self._ros2:
                    pair.server = self._ros2[way.name][1]
                found[way.name] = pair.server
        return found

    def _has_same_type(self, way: Way, pair: _Pair) -> bool:
        return self._type(way) in (None, pair.kind.ros1)

    def _is_as_begun(self, way: Way, pair: _Pair) -> bool:
        """Tell whether a pair is still offered by the right node: that may appear only later."""
        return isinstance(pair, ServiceToRos1) or pair.owner is self._owner(way)

    def _begin(self, way: Way) -> Optional[_Pair]:
        name, other = way.name, self._names.in_ros2(way.name) or way.name
        validate_full_topic_name(other, is_service=True)
        kind = self._type(way)
        if kind is None or kind.startswith(OWN_WAYS):
            return None
        found, node, participant = self._types.service(kind), self._node, self._participant
        if way.to_ros2:
            return ServiceToRos2(
                node, participant, self._owner(way), name, other, found, self._timeout
            )
        return ServiceToRos1(node, participant, name, other, found, self._timeout)

    def _owner(self, way: Way) -> Ros2Node:
        """Return the node that offers a service of ROS 1 in ROS 2."""
        return self._owners.get(self._ros1.services.get(way.name, ""), self._participant.node)

    def _type(self, way: Way) -> Optional[str]:
        """Return ROS 1's name of a service's type, None where it is not known yet."""
        if way.to_ros2:
            return self._types1.of(way.name)
        return self._types.ros1_name(self._ros2[way.name][0])
