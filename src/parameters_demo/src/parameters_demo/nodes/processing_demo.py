"""Node that subscribes to the sensors chosen by a parameter, and works at its own rate."""

from functools import partial
from typing import Any, Dict

import rospy

from nodekit import (
    EnumParameter,
    IntParameter,
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    Node,
    ParameterSet,
    run,
)
from parameters_demo.sensors import SENSORS

#: Number of cycles per status line.
_STATUS_CYCLES = 5


class ProcessingDemoParameters(ParameterSet):
    """Parameters of processing_demo."""

    processing_mode = EnumParameter(
        "all", choices=("all", *(f"{name}_only" for name in SENSORS)), help="Sensors to process"
    )
    processing_rate = IntParameter(
        10, minimum=1, maximum=30, unit="Hz", help="Processing rate in Hz"
    )


class ProcessingDemo:
    """Logs every fifth cycle the number of received messages, and a summary of the newest.

    Messages are received in one exclusive group and processed in another, so that neither waits for
    the other. Topics excluded by the mode are not subscribed to.

    :ROS Subscribers:
        - ``camera/image_color`` (sensor_msgs/Image)
        - ``lidar/points`` (sensor_msgs/LaserScan)
        - ``radar/tracks`` (parameters_demo_msgs/RadarTracks)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ProcessingDemoParameters`
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._receiving = MutuallyExclusiveCallbackGroup()
        processing = MutuallyExclusiveCallbackGroup()
        self._parameters = node.declare_parameters(
            ProcessingDemoParameters, on_change=self._on_change, group=processing
        )
        MultiThreadedExecutor(4).add_node(node)
        self._cycles = 0
        self._latest: Dict[str, Any] = {}
        self._counts: Dict[str, int] = {}
        self._subscriptions = node.create_scope()
        self._subscribe()
        node.create_timer(
            lambda: self._parameters.values.processing_rate, self.process, group=processing
        )

    def process(self, elapsed: float) -> None:
        """Process one cycle."""
        self._cycles += 1
        if self._cycles % _STATUS_CYCLES == 0:
            status = "; ".join(self._status(name) for name in self._counts)
            rospy.loginfo("cycle %d: %s", self._cycles, status)

    def _status(self, name: str) -> str:
        message = self._latest.get(name)
        summary = SENSORS[name].summarize(message) if message is not None else "no message"
        return f"{name} #{self._counts[name]}: {summary}"

    def _subscribe(self) -> None:
        """Subscribe to the topics of the mode, and unsubscribe from the others."""
        self._subscriptions.close()
        mode = self._parameters.values.processing_mode
        names = [name for name in SENSORS if mode in ("all", f"{name}_only")]
        self._latest = {}
        self._counts = dict.fromkeys(names, 0)
        self._subscriptions = self._node.create_scope()
        for name in names:
            sensor = SENSORS[name]
            callback = partial(self._on_message, name)
            self._subscriptions.create_subscription(
                sensor.topic, sensor.message, callback, 1, group=self._receiving
            )

    def _on_message(self, name: str, message: Any) -> None:
        self._latest[name] = message
        self._counts[name] += 1

    def _on_change(self, new: ProcessingDemoParameters, old: ProcessingDemoParameters) -> None:
        if new.processing_mode != old.processing_mode:
            self._subscribe()


def main() -> None:
    """Run the node until it is shut down."""
    run("processing_demo", ProcessingDemo)
