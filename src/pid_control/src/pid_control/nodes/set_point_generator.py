"""Set point node: publishes the motor's desired speed as any waveform."""

from basic_comms.signals.run_control import RUNNING, RunControl
from basic_comms.signals.signal_source import SignalSource
from nodekit import Node, run
from pid_control.msg import set_point
from pid_control.set_point_parameters import SetPointParameters


class SetPointGenerator:
    """Publisher of the motor's desired speed: any waveform, each sample with its time.

    The node publishes stop_value during the start delay, after the duration, and once when it shuts
    down or, if managed, is deactivated.

    :ROS Publishers:
        - ``set_point`` (pid_control/set_point)

    :ROS Parameters:
        - those of :class:`.SetPointParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(SetPointParameters)
        self._source = SignalSource()
        self._run_control = RunControl()
        self._elapsed = 0.0
        #: Whether a sample was published since the last stop, and whether the node shuts down.
        self._has_to_stop = self._has_ended = False
        self._group = node.default_group
        self._publisher = node.create_publisher("set_point", set_point)
        node.create_timer(lambda: self._settings.values.rate, self._publish)
        node.before_deactivate(self._stop)
        node.on_shutdown(self._end)

    def _publish(self, elapsed: float) -> None:
        if self._has_ended:
            return
        settings = self._settings.values
        self._elapsed, self._has_to_stop = elapsed, True
        status = self._run_control.at(elapsed, settings.start_delay, settings.duration)
        value = settings.stop_value
        if status.state == RUNNING:
            value = self._source.sample(status.time_x, settings).value
        self._publisher.publish(value, elapsed)

    def _stop(self) -> None:
        with self._group:
            if self._has_to_stop:
                self._has_to_stop = False
                self._publisher.publish(self._settings.values.stop_value, self._elapsed)

    def _end(self) -> None:
        with self._group:  # so that no sample in progress is sent after stop_value
            self._has_ended = True
            self._stop()


def main() -> None:
    """Run the node until it is shut down."""
    run("set_point_generator", SetPointGenerator)
