# Pure: knows no ROS.
"""Dead man's switch: a robot moves only while commands keep arriving."""

from typing import NamedTuple, Optional

#: How long a command counts [s]: a page repeats it well before.
HOLD_S = 0.2
#: How much the shortest way of a page's messages is taken to have grown, in s for each s: more
#: than any two clocks drift apart.
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
    """Decides what a robot is told, and when; times are s on the monotonic clock.

    A command counts for HOLD_S. Then one zero is due, and silence: the topic is free for others.
    A command that was under way for longer than that is from a time that is over, as when a link
    has stalled, and is left out.
    """

    def __init__(self) -> None:
        self._until: Optional[float] = None
        self._shortest: Optional[float] = None
        self._heard = 0.0

    @property
    def until(self) -> Optional[float]:
        """Time at which a zero is due; None while the robot stands."""
        return self._until

    def accept(self, velocity: Velocity, sent: float, now: float) -> Optional[Velocity]:
        """Take a command.

        :param velocity: what the robot is to do
        :param sent: when it was sent, by the sender's clock [s]
        :param now: the time [s]
        :returns: what to tell the robot now, None for nothing
        """
        late = self._lateness(sent, now) > HOLD_S
        if velocity == STOP:
            return self.stop() or (None if late else STOP)
        if late:
            return None
        self._until = now + HOLD_S
        return velocity

    def expire(self, now: float) -> Optional[Velocity]:
        """Return the zero if it is due, None otherwise.

        :param now: the time [s]
        """
        if self._until is None or now < self._until:
            return None
        self._until = None
        return STOP

    def stop(self) -> Optional[Velocity]:
        """Return the zero if the robot was told to move, None otherwise."""
        was_moving, self._until = self._until is not None, None
        return STOP if was_moving else None

    def _lateness(self, sent: float, now: float) -> float:
        """Return how much longer a message was under way than the quickest [s]."""
        way = now - sent
        if self._shortest is None:
            self._shortest = way
        self._shortest = min(way, self._shortest + _LEAK * (now - self._heard))
        self._heard = now
        return way - self._shortest
