"""Parameter services in ROS 2 for a ROS 1 node."""

import threading
import time
from typing import Any, Callable, Dict, List

import rospy
from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterValue,
    SetParametersResult,
)
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.node import Node as Ros2Node
from rclpy.parameter import Parameter as Ros2Parameter

from nodekit import NodeScope, ReentrantCallbackGroup, Throttle
from ros2_bridge.parameters import messages
from ros2_bridge.parameters.ros1_parameters import Parameter, Ros1Parameters, UnreadableParameters
from ros2_bridge.parameters.values import DOUBLE_FOR, changes, differs, flat, listed, unfit
from ros2_bridge.ros2.participant import Participant

Type = Ros2Parameter.Type
#: Most polls of a node for whether a new value is in force or reverted, and the pause [s].
_MOST_READS, _PAUSE_S = 20, 0.1
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 1.0


class ParametersToRos2:
    """ROS 2 parameter services for a ROS 1 node; also publishes its changes.

    :param scope: creates the subscription to the parameters; closed with this object
    :param participant: the bridge in ROS 2
    :param node: the ROS 2 node that represents it
    :param other: its global name in ROS 2
    :param parameters: its parameters
    :param publish: publishes an event
    :param is_kind: returns whether an integer is accepted for a double
    """

    def __init__(
        self,
        scope: NodeScope,
        participant: Participant,
        node: Ros2Node,
        other: str,
        parameters: Ros1Parameters,
        publish: Callable[[Any], None],
        is_kind: Callable[[], bool],
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._is_kind = is_kind
        self._scope, self._other, self._parameters = scope, other, parameters
        self._publish, self._clock = publish, node.get_clock()
        self._lock = threading.Lock()
        #: Held while a thread reads and publishes, so that an older reading is not published last.
        self._turn = threading.Lock()
        self._known: Dict[str, ParameterValue] = {}
        self._server: Dict[str, Any] = {}
        self._is_known = self._is_reading = self._again = False
        self._ends = [
            participant.create_service(node, cls, f"{other}/{verb}", self._beside(answer))
            for cls, verb, answer in (
                (ListParameters, "list_parameters", self._list),
                (GetParameters, "get_parameters", self._get),
                (GetParameterTypes, "get_parameter_types", self._types),
                (DescribeParameters, "describe_parameters", self._describe),
                (SetParameters, "set_parameters", self._set),
                (SetParametersAtomically, "set_parameters_atomically", self._set_atomically),
            )
        ]
        try:
            scope.on_parameter(parameters.name, self._publish_soon, group=ReentrantCallbackGroup())
        except BaseException:
            self.close()
            raise

    def _beside(self, answer: Callable[[Any], Any]) -> Callable[[Any, Callable[[Any], None]], None]:
        """Return a callback that answers in another thread, because it waits for the node."""

        def work(request: Any, send: Callable[[Any], None]) -> None:
            try:
                send(answer(request))
            except UnreadableParameters as error:
                # A ROS 2 service cannot report an error: no response.
                if self._throttle.is_due():
                    rospy.logwarn(f"cannot read the parameters of {self._parameters.name}: {error}")

        return lambda *given: threading.Thread(target=work, args=given, daemon=True).start()

    def _list(self, request: Any) -> Any:
        names, prefixes = listed(list(self._parameters.read()), request.prefixes, request.depth)
        result = ListParametersResult(names=names, prefixes=prefixes)
        return ListParameters.Response(result=result)

    def _found(self, names: List[str]) -> List[Parameter]:
        """Return the named parameters, or none if one is unknown, as rclpy does."""
        known = self._parameters.read()
        return [known[name] for name in names] if set(names) <= set(known) else []

    def _get(self, request: Any) -> Any:
        found = self._found(request.names)
        values = [messages.to_message(one.value, one.kind) for one in found]
        return GetParameters.Response(values=values)

    def _types(self, request: Any) -> Any:
        return GetParameterTypes.Response(types=[one.kind for one in self._found(request.names)])

    def _describe(self, request: Any) -> Any:
        descriptors = [
            messages.descriptor(name, one.entry)
            if one.entry is not None
            else ParameterDescriptor(name=name, type=one.kind, dynamic_typing=True)
            for name, one in zip(request.names, self._found(request.names))
        ]
        return DescribeParameters.Response(descriptors=descriptors)

    def _set(self, request: Any) -> Any:
        results = [self._change([one]) for one in request.parameters]
        return SetParameters.Response(results=results)

    def _set_atomically(self, request: Any) -> Any:
        return SetParametersAtomically.Response(result=self._change(request.parameters))

    def _change(self, parameters: List[Any]) -> SetParametersResult:
        """Send several values to the node, which accepts all or none."""
        values = {one.name: messages.to_plain(one.value) for one in parameters}
        reasons = [reason for reason in (unfit(*item) for item in values.items()) if reason]
        reasons = reasons or self._wrong_types(parameters)
        reason = "; ".join(reasons) or self._parameters.change(values)
        if not reason:
            self._publish_changes()
        message = reason or self._parameters.caution(list(values))
        return SetParametersResult(successful=not reason, reason=message)

    def _wrong_types(self, parameters: List[Any]) -> List[str]:
        """Return errors for integers given to doubles, which rclpy rejects as well."""
        given = {one.name: one.value.type for one in parameters if one.value.type in DOUBLE_FOR}
        if not given or self._is_kind():
            return []
        try:
            known = self._parameters.read()
        except UnreadableParameters as error:
            return [str(error)]
        return [
            f"Wrong parameter type, expected '{Type(known[name].kind)}' got '{Type(kind)}'"
            for name, kind in given.items()
            if name in known and known[name].entry and known[name].kind == DOUBLE_FOR[kind]
        ]

    def _publish_soon(self, tree: Any) -> None:
        """Publish changes in another thread, and once more if that is already running.

        :param tree: current content of the server
        """
        with self._lock:
            self._server = flat(tree) if isinstance(tree, dict) else {}
            self._again = True
            if self._is_reading:
                return
            self._is_reading = True
        threading.Thread(target=self._publish_until_in_force, daemon=True).start()

    def _publish_until_in_force(self) -> None:
        reads = 0
        try:
            while True:
                with self._lock:
                    reads = 0 if self._again else reads
                    self._again = False
                in_force = self._publish_changes()
                reads += 1
                with self._lock:
                    # The node validates changes on the server with some delay.
                    behind = reads < _MOST_READS and differs(self._server, in_force)
                    if not (behind or self._again):
                        self._is_reading = False
                        return
                time.sleep(_PAUSE_S)
        except Exception:  # otherwise changes would never be read again
            with self._lock:
                self._is_reading = False
            raise

    def _publish_changes(self) -> Dict[str, Any]:
        """Publish changes of the values in force; rejected values are not published.

        :returns: the values in force
        """
        with self._turn:
            try:
                read = self._parameters.read()
            except UnreadableParameters:
                return {}  # the node has ended, or is ending
            now = {name: messages.to_message(one.value, one.kind) for name, one in read.items()}
            parts = changes(self._known, now)
            is_first, self._known, self._is_known = not self._is_known, now, True
            if any(parts) and not is_first:
                stamp = self._clock.now().to_msg()
                self._publish(messages.event(self._other, stamp, *parts))
            return {name: one.value for name, one in read.items()}

    def close(self) -> None:
        """Close the services."""
        self._scope.close()
        for end in self._ends:
            end()
