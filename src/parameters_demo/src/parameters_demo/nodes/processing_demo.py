"""A node that hears the sensors that a parameter names, and works at its own rate."""

from functools import partial
from typing import Any, Dict

import rospy

from nodekit import EnumParameter, IntParameter, MultiThreadedExecutor, Node, ParameterSet, run
from parameters_demo.sensors import SENSORS

#: Cycles from one status to the next.
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
    """Logs every fifth cycle what it has heard of which sensors, and what that says.

    Messages are heard in one exclusive group and processed in another, so that one does not wait
    for the other. A topic that the mode leaves out is not even subscribed to.

    :ROS Subscribers:
        - ``camera/image_color`` (sensor_msgs/Image)
        - ``lidar/points`` (sensor_msgs/LaserScan)
        - ``radar/tracks`` (parameters_demo_msgs/RadarTracks)

    :ROS Parameters:
        - those of :class:`ProcessingDemoParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._hearing, processing = node.group(), node.group()
        self._parameters = node.parameters(
            ProcessingDemoParameters, on_change=self._on_change, group=processing
        )
        MultiThreadedExecutor(4).add_node(node)
        self._cycles = 0
        self._latest: Dict[str, Any] = {}
        self._counts: Dict[str, int] = {}
        self._heard = node.lifetime()
        self._hear()
        node.every(lambda: self._parameters.values.processing_rate, self.process, group=processing)

    def process(self, elapsed: float) -> None:
        """Work for a cycle."""
        self._cycles += 1
        if self._cycles % _STATUS_CYCLES == 0:
            status = "; ".join(self._status(name) for name in self._counts)
            rospy.loginfo("cycle %d: %s", self._cycles, status)

    def _status(self, name: str) -> str:
        message = self._latest.get(name)
        told = SENSORS[name].tell(message) if message is not None else "nothing heard"
        return f"{name} #{self._counts[name]}: {told}"

    def _hear(self) -> None:
        """Hear what the mode names, and no longer anything else."""
        self._heard.close()
        mode = self._parameters.values.processing_mode
        names = [name for name in SENSORS if mode in ("all", f"{name}_only")]
        self._latest, self._counts = {}, dict.fromkeys(names, 0)
        self._heard = self._node.lifetime()
        for name in names:
            sensor, take = SENSORS[name], partial(self._take, name)
            self._heard.subscribe(sensor.topic, sensor.message, take, 1, group=self._hearing)

    def _take(self, name: str, message: Any) -> None:
        self._latest[name] = message
        self._counts[name] += 1

    def _on_change(self, new: ProcessingDemoParameters, old: ProcessingDemoParameters) -> None:
        if new.processing_mode != old.processing_mode:
            self._hear()


def main() -> None:
    """Run the node until it is shut down."""
    run("processing_demo", ProcessingDemo)
