"""The set point: tells a motor what to do, once that is enabled."""

from std_msgs.msg import Float32

from basic_comms.signals.run_control import RUNNING, RunControl
from basic_comms.signals.signal_source import SignalSource
from motor_control.motor_enabler import MotorEnabler
from motor_control.set_point_parameters import SetPointParameters
from nodekit.life.names import NodeScope
from nodekit.live.live_parameters import LiveParameters
from nodekit.messaging.publisher import Publisher
from nodekit.process.run import run
from nodekit.timing.scheduler import get_scheduler


class SetPoint:
    """Publishes the input of a motor, by default u = amplitude sin(omega t).

    It has the motor enabled first and is silent until it is. When the motor is disabled or gone, a
    last stop_value goes out, and the signal's time stands still until it goes on.

    :ROS Publishers:
        - ``motor_input_u`` (std_msgs/Float32)

    :ROS Subscribers and Services called:
        - those of :class:`.MotorEnabler`

    :ROS Parameters:
        - those of :class:`.SetPointParameters`, private and live

    :param scope: where the names above are; those of the process's own node by default
    """

    def __init__(self, scope: NodeScope = NodeScope()) -> None:
        self._parameters = LiveParameters(SetPointParameters, scope.parameters)
        self._source = SignalSource()
        self._run_control = RunControl(enabled=False)
        self._ran = False
        self._publisher = Publisher(scope.topic("motor_input_u"), Float32)
        self._motor = MotorEnabler(scope)
        self._task = get_scheduler().every(self._parameters.values.rate, self._publish)
        self._parameters.start(on_change=lambda new, old: self._task.set_rate(new.rate))

    def _publish(self, elapsed: float) -> None:
        settings = self._parameters.values
        runs, ran = self._motor.may_publish, self._ran
        self._ran = runs
        self._run_control.enable(elapsed, runs)
        if not runs:
            if ran:
                self._publisher.publish(Float32(settings.stop_value))
            return
        status = self._run_control.at(elapsed, settings.start_delay, settings.duration)
        value = settings.stop_value
        if status.state == RUNNING:
            value = self._source.sample(status.time_x, settings).value
        self._publisher.publish(Float32(value))


def main() -> None:
    """Run the node until it is shut down."""
    run("set_point", SetPoint)
