"""Health of the bridge, published on ``/diagnostics`` in both ROSes."""

import io
import socket
from typing import Sequence

import rospy

from nodekit import Node
from ros2_bridge.environment.ros1_messages import (
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    KeyValue,
)
from ros2_bridge.health.reports import Status
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.types.type_registry import TypeRegistry

_TOPIC = "/diagnostics"


class Diagnostics:
    """Publisher of diagnostics, in both ROSes: the bridge does not forward its own messages.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param types: the message types
    :param names: renaming rules
    """

    def __init__(
        self, node: Node, participant: Participant, types: TypeRegistry, names: Renaming
    ) -> None:
        self._node = node
        # The bridge's own class for ROS 1 topics: rospy allows one class per topic in a process.
        self._type = types.message("diagnostic_msgs/DiagnosticArray")
        self._publisher1 = node.create_publisher(_TOPIC, self._type.raw)
        self._publisher2 = participant.create_publisher(
            participant.node, self._type.cls, names.in_ros2(_TOPIC) or _TOPIC, QosProfile(10)
        )

    def has_subscribers(self) -> bool:
        """Return whether a node of either ROS subscribes to the diagnostics."""
        return bool(
            self._publisher1.get_num_connections() or self._publisher2.get_subscription_count()
        )

    def publish(self, statuses: Sequence[Status]) -> None:
        """Publish the statuses of the bridge."""
        prefix, machine = self._node.name.lstrip("/"), socket.gethostname()
        array = DiagnosticArray(
            Header(stamp=rospy.get_rostime()),
            [
                DiagnosticStatus(
                    status.level,
                    f"{prefix}: {status.name}",
                    status.message,
                    machine,
                    [KeyValue(name, value) for name, value in status.values],
                )
                for status in statuses
            ],
        )
        buffer = io.BytesIO()
        array.serialize(buffer)
        message = self._type.raw()
        message._buff = buffer.getvalue()
        self._publisher1.publish(message)
        self._publisher2.publish(self._type.codec.to_cdr(message._buff))
