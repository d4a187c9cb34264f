"""Keyboard teleoperation node, for a terminal."""

import sys
import threading
import time

import rospy

from bot_controller_demo.driving.commands import Commands
from bot_controller_demo.driving.parameters import controller_type
from bot_controller_demo.control.velocities import MODELS, Limits, Velocity, clamp
from bot_controller_demo.teleop.keys import HELP, SCALES, Teleoperation, TimeOuts, split
from bot_controller_demo.teleop.terminal import KeyTerminal
from nodekit import (
    EnumParameter,
    FloatParameter,
    MasterUnreachable,
    Node,
    ParameterSet,
    RateParameter,
    rule,
    run,
)

#: Longest wait for a key [s]; shutdown is noticed after it.
_PATIENCE_S = 0.2
_PROGRAM = "teleop_keyboard"


def _time_out(default: float, help: str) -> FloatParameter:
    return FloatParameter(default, above=0.0, maximum=10.0, unit="s", help=help)


class TeleopKeyboardParameters(ParameterSet):
    """Parameters of teleop_keyboard."""

    controller_type = controller_type()
    model = EnumParameter("burger", choices=tuple(MODELS), help="the robot, for its limits")
    speed = FloatParameter(
        0.2,
        minimum=0.0,
        maximum=100.0,
        unit="m/s",
        help="speed of the keys i and ,; other keys change it; at most the model's",
    )
    turn = FloatParameter(
        1.0,
        minimum=0.0,
        maximum=100.0,
        unit="rad/s",
        help="turning rate of the keys j and l; other keys change it; at most the model's",
    )
    first_timeout = _time_out(0.6, "how long a key counts as held after its first press")
    repeat_timeout = _time_out(0.15, "how long a key counts as held while the terminal repeats it")
    rate = RateParameter(20.0, maximum=1000.0, help="commands per second while a key is held")

    @rule("speed", "turn", "model")
    def is_within_limits(self) -> None:
        """Reject speeds beyond the robot's limits."""
        if self.speed > self.limits.linear:
            raise ValueError(
                f"speed must be at most {self.limits.linear:g} m/s, the limit of this model"
            )
        if self.turn > self.limits.angular:
            raise ValueError(
                f"turn must be at most {self.limits.angular:g} rad/s, the limit of this model"
            )

    @property
    def limits(self) -> Limits:
        """Largest velocities of the robot."""
        return MODELS[self.model]

    @property
    def speeds(self) -> Velocity:
        """Velocity of a held key."""
        return Velocity(self.speed, self.turn)

    @property
    def time_outs(self) -> TimeOuts:
        """Times for which a key counts as held."""
        return TimeOuts(self.first_timeout, self.repeat_timeout)


class TeleopKeyboard:
    """Drives a robot while a key is held; one zero when it is released, then silence.

    :ROS Publishers:
        - ``cmd_vel`` (geometry_msgs/Twist, or TwistStamped)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`TeleopKeyboardParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(TeleopKeyboardParameters, self._on_change)
        self._commands = Commands(node, self._parameters.values.controller_type)
        self._teleoperation = Teleoperation()
        self._lock = threading.Lock()
        self._terminal = node.own(KeyTerminal(sys.stdin.fileno()))
        node.on_shutdown(self._terminal.close)
        # By the machine's clock, because /clock may be stopped.
        node.create_timer(lambda: self._parameters.values.rate, self._drive, steady=True)
        print(HELP, flush=True)
        self._print_speeds()
        threading.Thread(target=self._read, name="keys", daemon=True).start()

    def _read(self) -> None:
        try:
            while not rospy.is_shutdown():
                for key in split(self._terminal.read(_PATIENCE_S)):
                    self._on_key(key)
        except EOFError as error:
            rospy.signal_shutdown(str(error))

    def _on_key(self, key: str) -> None:
        settings = self._parameters.values
        with self._lock:
            self._teleoperation.press(key, time.monotonic(), settings.time_outs)
        self._drive(0.0)
        if key in SCALES:
            linear, angular = SCALES[key]
            scaled = Velocity(settings.speeds.linear * linear, settings.speeds.angular * angular)
            speeds = clamp(scaled, settings.limits)
            try:
                self._parameters.update(speed=speeds.linear, turn=speeds.angular)
            except MasterUnreachable as error:
                rospy.logwarn("the speeds are unchanged: %s", error)

    def _drive(self, _elapsed: float) -> None:
        settings = self._parameters.values
        with self._lock:
            now = time.monotonic()
            velocity = self._teleoperation.velocity(now, settings.speeds, settings.time_outs)
            if velocity is not None:
                self._commands.publish(velocity)

    def _on_change(self, new: TeleopKeyboardParameters, old: TeleopKeyboardParameters) -> None:
        if new.speeds != old.speeds:
            self._print_speeds()

    def _print_speeds(self) -> None:
        speeds = self._parameters.values.speeds
        print(f"speed {speeds.linear:.3g} m/s, turn {speeds.angular:.3g} rad/s", flush=True)


def main() -> None:
    """Run the node until it is shut down."""
    if not sys.stdin.isatty():
        sys.exit(
            f"{_PROGRAM}: standard input is not a terminal, so there are no keys to read; "
            f"start it in its own terminal: rosrun bot_controller_demo {_PROGRAM}"
        )
    run(_PROGRAM, TeleopKeyboard)
