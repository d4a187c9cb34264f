"""Robot description of ROS 1's parameter server, as the latched topic that ROS 2 uses for it."""

import struct
from typing import Any, Dict, Optional

from nodekit import Node, ReentrantCallbackGroup
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import Rules, Route
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.types.type_registry import TypeRegistry

#: Name of the parameter, and of the topic of ROS 2's robot_state_publisher.
NAME = "/robot_description"


class RobotDescription:
    """Publisher of the robot description while no node of either ROS publishes one.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param types: the message types
    :param skip_log: receives a description that is not a text
    """

    def __init__(
        self, node: Node, participant: Participant, types: TypeRegistry, skip_log: SkipLog
    ) -> None:
        self._participant, self._types, self._skip_log = participant, types, skip_log
        self._value: Any = None
        self._published: Optional[str] = None
        self._publisher: Any = None
        node.on_parameter(NAME, self._keep, group=ReentrantCallbackGroup())

    def _keep(self, value: Any) -> None:
        self._value = value

    def update(self, rules: Rules, ros1: Ros1Graph, ros2: Dict[str, Topic]) -> None:
        """Publish the current description, or withdraw it, after a poll of both graphs.

        :param ros2: the ROS 2 topics, by ROS 1 name
        """
        value = self._value
        is_others = NAME in ros1.publishers or (NAME in ros2 and bool(ros2[NAME].publishers))
        if is_others or not rules.enables(Route(NAME, True)):
            value = None
        elif value is not None and not isinstance(value, str):
            self._skip_log.report(f"the parameter {NAME} of ROS 1: not a text")
            value = None
        if value == self._published:
            return
        if value is None:
            self._participant.destroy_publisher(self._participant.node, self._publisher)
            self._publisher = None
        else:
            self._publish(value, rules.names.in_ros2(NAME) or NAME)
        self._published = value

    def _publish(self, text: str, topic: str) -> None:
        kind = self._types.message("std_msgs/String")
        if self._publisher is None:
            quality = QosProfile(1, latched=True)
            node = self._participant.node
            self._publisher = self._participant.create_publisher(node, kind.cls, topic, quality)
        data = text.encode()
        self._publisher.publish(kind.codec.to_cdr(struct.pack("<I", len(data)) + data))
