# Pure: knows no ROS.
"""Commands of the teleoperation's keys, and their duration.

A terminal reports a key when it is pressed, and repeatedly while it is held, from about half a
second on. It does not report the release, which follows only from silence.
"""

import math
import re
from typing import Dict, List, NamedTuple, Optional, Tuple

from bot_controller_demo.control.velocities import STOP, Velocity

#: Keys that move the robot: relative speed, relative turning rate.
MOVES: Dict[str, Tuple[float, float]] = {
    "u": (1.0, 1.0),
    "i": (1.0, 0.0),
    "o": (1.0, -1.0),
    "j": (0.0, 1.0),
    "k": (0.0, 0.0),
    "l": (0.0, -1.0),
    "m": (-1.0, -1.0),
    ",": (-1.0, 0.0),
    ".": (-1.0, 1.0),
}
#: Keys that change the speeds: factors of the linear and of the angular speed.
SCALES: Dict[str, Tuple[float, float]] = {
    "q": (1.1, 1.1),
    "z": (0.9, 0.9),
    "w": (1.1, 1.0),
    "x": (0.9, 1.0),
    "e": (1.0, 1.1),
    "c": (1.0, 0.9),
}
HELP = """\
Drive while a key is held:      Speeds, 10 % a press:

   u    i    o                  q/z  both, up and down
   j    k    l                  w/x  the linear one
   m    ,    .                  e/c  the angular one

Any other key stops the robot; Ctrl-C ends this."""

#: A key, or the escape sequence of a special key such as an arrow.
_KEY = re.compile("\x1b(?:\\[|O)[0-9;]*[A-Za-z~]|.", re.DOTALL)


def split(text: str) -> List[str]:
    """Return the pressed keys.

    :param text: input from the terminal
    """
    return _KEY.findall(text)


class TimeOuts(NamedTuple):
    """Times for which a key counts as held without further input from the terminal.

    :param first: after its first press [s]; longer than the terminal's delay before it repeats
    :param repeated: while it repeats [s]
    """

    first: float
    repeated: float


class HeldKey:
    """Currently held key, inferred from presses.

    Two presses of a key within the shorter timeout count as the terminal's repetition. Quick manual
    presses are further apart, and each is a new press.
    """

    def __init__(self) -> None:
        self.key: Optional[str] = None
        self._pressed_at = -math.inf
        self._repeats = False

    def press(self, key: str, now: float, time_outs: TimeOuts) -> None:
        """Record a press.

        :param key: pressed or repeated key
        :param now: monotonic time [s]
        :param time_outs: how long it counts as held
        """
        gap = now - self._pressed_at
        self._repeats = key == self.key and gap <= time_outs.repeated
        self.key, self._pressed_at = key, now

    def release(self) -> None:
        """Count the key as released."""
        self.key = None

    def held(self, now: float, time_outs: TimeOuts) -> Optional[str]:
        """Return the held key, or None.

        :param now: time by the same clock [s]
        :param time_outs: how long a key counts as held
        """
        limit = time_outs.repeated if self._repeats else time_outs.first
        if now - self._pressed_at > limit:
            self.key = None
        return self.key


class Teleoperation:
    """Converter of key presses to velocities: the key's while held, one zero, then none."""

    def __init__(self) -> None:
        self._held = HeldKey()
        self._moves = False

    def press(self, key: str, now: float, time_outs: TimeOuts) -> None:
        """Record a key that moves the robot; any other key stops it.

        :param key: pressed or repeated key
        :param now: monotonic time [s]
        :param time_outs: how long it counts as held
        """
        if any(MOVES.get(key, ())):
            self._held.press(key, now, time_outs)
        else:
            self._held.release()

    def velocity(self, now: float, speeds: Velocity, time_outs: TimeOuts) -> Optional[Velocity]:
        """Return the current command to the robot, or None.

        :param now: time by the same clock [s]
        :param speeds: velocity at a relative speed of 1
        :param time_outs: how long a key counts as held
        """
        key = self._held.held(now, time_outs)
        moved, self._moves = self._moves, key is not None
        if key is None:
            return STOP if moved else None
        linear, angular = MOVES[key]
        return Velocity(linear * speeds.linear, angular * speeds.angular)
