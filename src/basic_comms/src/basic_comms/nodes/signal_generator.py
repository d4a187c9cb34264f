"""Signal generator node: publishes samples of a waveform."""

from typing import Optional

import rospy
from std_msgs.msg import String
from std_srvs.srv import (
    SetBool,
    SetBoolRequest,
    SetBoolResponse,
    Trigger,
    TriggerRequest,
    TriggerResponse,
)

from basic_comms.msg import signal_msg
from basic_comms.signals.run_control import RUNNING, RunControl, RunStatus
from basic_comms.signals.signal_parameters import SignalParameters
from basic_comms.signals.signal_source import SignalSource
from nodekit import Node, run

#: On a machine that is busy for up to this long, samples are late, but not lost [s].
_CATCH_UP_S = 0.5
#: A process node that starts this much later still receives the first sample [s].
_LIFESPAN_S = 0.1


class SignalGenerator:
    """Publishes a signal, sample by sample; by default y = amplitude sin(frequency time_x).

    Each sample has its own time: its nominal time, n / rate after the first one, not the slightly
    later time at which it was sent. A change of a parameter takes effect at a sample and never
    makes the phase jump. While the signal does not run, stop_value is published with amplitude and
    frequency 0, and time_x does not advance.

    :ROS Publishers:
        - ``signal`` (basic_comms/signal_msg)
        - ``~status`` (std_msgs/String), latched: ``running``, ``idle`` or ``finished``, and the
          signal's time [s]

    :ROS Services:
        - ``~enable`` (std_srvs/SetBool): stop the signal, or continue it from there
        - ``~reset`` (std_srvs/Trigger): time_x and phase restart at 0

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.SignalParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(SignalParameters, on_change=self._on_change)
        self._source = SignalSource()
        self._enabled = self._settings.values.autostart
        self._run_control = RunControl(self._enabled)
        # Requests are executed at the next sample, which determines the signal's time.
        self._wanted: Optional[bool] = None
        self._reset_wanted = False
        self._state = ""
        self._publisher = node.create_publisher("signal", signal_msg, lifespan=_LIFESPAN_S)
        self._status_publisher = node.create_publisher("~status", String, latch=True)
        node.create_service("~enable", SetBool, self._enable)
        node.create_service("~reset", Trigger, self._reset)
        node.create_timer(lambda: self._settings.values.rate, self._publish, catch_up=_CATCH_UP_S)
        self._warn_of_aliasing(self._settings.values)

    def _on_change(self, new: SignalParameters, _old: SignalParameters) -> None:
        self._warn_of_aliasing(new)

    def _publish(self, elapsed: float) -> None:
        settings = self._settings.values
        if self._wanted is not None or self._reset_wanted:
            self._carry_out_requests(elapsed)
        status = self._run_control.at(elapsed, settings.start_delay, settings.duration)
        message = signal_msg()
        message.time_x = status.time_x
        if status.state == RUNNING:
            sample = self._source.sample(status.time_x, settings)
            message.amplitude = sample.amplitude
            message.frequency = sample.frequency
            message.signal_y = sample.value
        else:
            message.amplitude = message.frequency = 0.0
            message.signal_y = settings.stop_value
        self._publisher.publish(message)
        if status.state != self._state:
            self._publish_status(status)

    def _carry_out_requests(self, elapsed: float) -> None:
        if self._wanted is not None:
            self._run_control.enable(elapsed, self._wanted)
            self._wanted = None
        if self._reset_wanted:
            self._reset_wanted = False
            self._run_control.reset()
            self._source.reset()
            self._state = ""  # so that it is published again

    def _publish_status(self, status: RunStatus) -> None:
        self._state = status.state
        self._status_publisher.publish(String(str(status)))
        rospy.loginfo("%s: %s s", self._publisher.resolved_name, status)

    def _enable(self, request: SetBoolRequest) -> SetBoolResponse:
        changed = request.data != self._enabled
        self._enabled = self._wanted = request.data
        state = "enabled" if request.data else "stopped"
        return SetBoolResponse(True, state if changed else f"{state} already")

    def _reset(self, _request: TriggerRequest) -> TriggerResponse:
        self._reset_wanted = True
        return TriggerResponse(True, "time_x and phase start at 0 again")

    def _warn_of_aliasing(self, settings: SignalParameters) -> None:
        if settings.aliasing:
            rospy.logwarn("%s: %s", self._publisher.resolved_name, settings.aliasing)


def main() -> None:
    """Run the node until it is shut down."""
    run("signal_generator", SignalGenerator)
