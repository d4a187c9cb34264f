"""Process node: scales, shifts and offsets the signal."""

import time
from typing import List, Optional

import rospy
from std_msgs.msg import Float32

from basic_comms.conditioning.conditioner import Conditioner
from basic_comms.conditioning.lateness import LatenessMonitor
from basic_comms.conditioning.process_parameters import ProcessParameters
from basic_comms.msg import signal_msg
from nodekit import Node, Throttle, run

#: Shortest time between two warnings about the same kind of invalid input [s].
_WARN_EVERY_S = 10.0
#: A subscriber that connects this soon after an answer still receives it [s]: nodes start in turn.
_LIFESPAN_S = 0.1


class Process:
    """Publishes the conditioned signal, at each sample or at its own rate.

    :ROS Subscribers:
        - ``signal`` (basic_comms/signal_msg)

    :ROS Publishers:
        - ``proc_signal`` (std_msgs/Float32); nothing before the first sample

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.ProcessParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(ProcessParameters)
        self._conditioner = Conditioner()
        self._throttle = Throttle(_WARN_EVERY_S)
        self._lateness = LatenessMonitor()
        # time_x follows /clock if there is one.
        self._now = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        self._latest: Optional[float] = None
        self._publisher = node.create_publisher("proc_signal", Float32, lifespan=_LIFESPAN_S)
        self._input = node.resolve("signal")
        node.create_batch_subscription("signal", signal_msg, self._on_signal)
        node.create_timer(lambda: self._settings.values.rate, self._publish_latest)

    def _on_signal(self, samples: List[signal_msg]) -> None:
        settings = self._settings.values
        conditioner = self._conditioner
        rejected, restarts = conditioner.rejected, conditioner.restarts
        answers = []
        if self._lateness.update(self._now(), samples):
            self._warn_of_lateness()
        for sample in samples:
            value = conditioner.process(
                sample.amplitude, sample.frequency, sample.time_x, sample.signal_y, settings
            )
            if value is not None:
                self._latest = value
                answer = Float32()  # filled in afterwards, which takes genpy half the time
                answer.data = value
                answers.append(answer)
        if settings.rate == 0.0:
            self._publisher.publish_all(answers)
        if conditioner.restarts != restarts:
            self._warn_of_restart(samples[-1].time_x)
        if conditioner.rejected != rejected:
            self._warn_of_rejection()

    def _publish_latest(self, _elapsed: float) -> None:
        if self._latest is not None:
            self._publisher.publish(Float32(self._latest))

    def _warn_of_restart(self, time_x: float) -> None:
        if self._throttle.is_due("restart"):
            text = (
                "%s: time_x went back or repeated itself (now %g s): searching for the phase again"
            )
            rospy.logwarn(text, self._input, time_x)

    def _warn_of_lateness(self) -> None:
        lateness = self._lateness
        if not self._throttle.is_due("late" if lateness.is_late else "in time again"):
            return
        if lateness.is_late:
            rospy.logwarn("%s: samples are %.1f s late", self._input, lateness.worst)
        else:
            text = "%s: samples are in time again; %d were late, by up to %.1f s"
            rospy.logwarn(text, self._input, lateness.count, lateness.worst)

    def _warn_of_rejection(self) -> None:
        if self._throttle.is_due("rejection"):
            text = "%s: %d samples dropped so far, because a field or the result is not finite"
            rospy.logwarn(text, self._input, self._conditioner.rejected)


def main() -> None:
    """Run the node until it is shut down."""
    run("process", Process)
