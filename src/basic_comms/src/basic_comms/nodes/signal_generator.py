"""The signal generator: publishes samples of a waveform."""

import math

import rospy

from basic_comms.live_parameters import LiveParameters
from basic_comms.msg import signal_msg
from basic_comms.node_main import run
from basic_comms.oscillator import PhaseAccumulator
from basic_comms.parameters import FloatParameter, ParameterSet
from basic_comms.scheduling import Scheduler
from basic_comms.waveforms import sine


class SignalGeneratorParameters(ParameterSet):
    """Private parameters of the signal generator."""

    rate = FloatParameter(
        10.0, above=0.0, maximum=10000.0, unit="Hz", help="how many samples a second are published"
    )
    amplitude = FloatParameter(
        2.0, minimum=0.0, maximum=1e9, help="peak of the signal around its offset"
    )
    frequency = FloatParameter(
        2.0 * math.pi,
        minimum=-1e6,
        maximum=1e6,
        unit="rad/s",
        help="angular frequency; 0 holds the signal, a negative one runs it backwards",
    )
    phase = FloatParameter(
        0.0, minimum=-1e6, maximum=1e6, unit="rad", help="added to the phase of the signal"
    )
    offset = FloatParameter(
        0.0, minimum=-1e9, maximum=1e9, help="added to the signal; its mean for most shapes"
    )


class SignalGenerator:
    """Publishes y = amplitude sin(frequency t + phase) + offset, sample by sample.

    Sample n carries its own time: it belongs to the moment n / rate after the
    first, which is also when it is published. A change of a parameter takes
    effect at a sample and never makes the phase jump.

    :ROS Publishers:
        - ``signal`` (basic_comms/signal_msg)

    :ROS Parameters:
        - those of :class:`SignalGeneratorParameters`, private and live
    """

    def __init__(self) -> None:
        self._parameters = LiveParameters(SignalGeneratorParameters)
        self._oscillator = PhaseAccumulator()
        self._publisher = rospy.Publisher("signal", signal_msg, queue_size=10)
        self._task = Scheduler().every(self._parameters.values.rate, self._publish)
        self._parameters.start(on_change=lambda new, old: self._task.set_rate(new.rate))

    def _publish(self, time_x: float) -> None:
        settings = self._parameters.values
        phase = self._oscillator.advance(time_x, settings.frequency) + settings.phase
        y = settings.amplitude * sine(phase) + settings.offset
        self._publisher.publish(settings.amplitude, settings.frequency, time_x, y)


def main() -> None:
    """Run the node until it is shut down."""
    run("signal_generator", SignalGenerator)
