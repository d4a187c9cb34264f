"""The log of ROS 1's nodes, in ROS 2's."""

from typing import Any, Callable

from rcl_interfaces.msg import Log

from nodekit import Node
from ros2_bridge.environment.ros1_messages import Log as Ros1Log
from ros2_bridge.ros2.side import Ros2
from ros2_bridge.rules.pairing import ROSOUT
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import Quality
from ros2_bridge.topics.one_topic import OnDemand

#: ROS 2's levels by ROS 1's.
_LEVELS = {1: Log.DEBUG, 2: Log.INFO, 4: Log.WARN, 8: Log.ERROR, 16: Log.FATAL}


class Rosout:
    """Forwards lines of the log, under the names of their nodes.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param names: what has another name in ROS 2

    :ivar subscription: to ROS 1's log; to be switched on while ROS 2's has subscribers
    """

    def __init__(self, node: Node, side: Ros2, names: Renaming) -> None:
        self._node, self._names = node, names
        self._publisher = side.publisher(Log, ROSOUT, Quality(1000, latched=True))
        self.subscription = OnDemand(self._subscribe)

    def _subscribe(self) -> Callable[[], None]:
        made = self._node.lifetime()
        made.subscribe(ROSOUT, Ros1Log, self._forward, group=made.group(exclusive=False))
        return made.close

    def _forward(self, line: Any) -> None:
        log = Log(
            level=_LEVELS.get(line.level, Log.INFO),
            # ROS 2 writes names of loggers with dots.
            name=(self._names.in_ros2(line.name) or line.name).strip("/").replace("/", "."),
            msg=line.msg,
            file=line.file,
            function=line.function,
            line=line.line,
        )
        log.stamp.sec, log.stamp.nanosec = line.header.stamp.secs, line.header.stamp.nsecs
        self._publisher.publish(log)
