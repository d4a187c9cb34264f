# Pure: knows no ROS.
"""Dead man's switch: a robot moves only while commands keep arriving."""

from typing import NamedTuple, Optional

#: Timeout of a command [s]; a page repeats it well before.
HOLD_S = 0.2
#: Assumed growth of the shortest delay of a page's messages [s/s]: larger than the relative drift
#: of any two clocks.
_LEAK = 1e-3


class Velocity(NamedTuple):
    """Velocity of a robot.

    :param speed: forward [m/s]
    :param turn: counter-clockwise [rad/s]
    """

    speed: float
    turn: float


STOP = Velocity(0.0, 0.0)


class DeadMan:
    """Dead man's switch of one robot; times are s on the monotonic clock.

    A command is valid for HOLD_S. Then a single zero is published, and the topic is free for
    others. A command that was delayed for longer, e.g. by a stalled link, is outdated and ignored.
    """

    def __init__(self) -> None:
        self._until: Optional[float] = None
        self._shortest: Optional[float] = None
        self._heard = 0.0

    @property
    def until(self) -> Optional[float]:
        """Time at which to publish the zero; None while the robot is stopped."""
        return self._until

    def accept(self, velocity: Velocity, sent: float, now: float) -> Optional[Velocity]:
        """Process a command.

        :param velocity: the commanded velocity
        :param sent: time of sending, by the sender's clock [s]
        :param now: the time [s]
        :returns: the velocity to publish now; None for none
        """
        late = self._lateness(sent, now) > HOLD_S
        if velocity == STOP:
            return self.stop() or (None if late else STOP)
        if late:
            return None
        self._until = now + HOLD_S
        return velocity

    def expire(self, now: float) -> Optional[Velocity]:
        """Return the zero if the command has timed out; None otherwise.

        :param now: the time [s]
        """
        if self._until is None or now < self._until:
            return None
        self._until = None
        return STOP

    def stop(self) -> Optional[Velocity]:
        """Return the zero if the robot was commanded to move; None otherwise."""
        was_moving, self._until = self._until is not None, None
        return STOP if was_moving else None

    def _lateness(self, sent: float, now: float) -> float:
        """Return the delay of a message in excess of the shortest delay [s]."""
        way = now - sent
        if self._shortest is None:
            self._shortest = way
        self._shortest = min(way, self._shortest + _LEAK * (now - self._heard))
        self._heard = now
        return way - self._shortest
