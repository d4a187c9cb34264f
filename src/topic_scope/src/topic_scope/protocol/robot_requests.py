"""What a page may ask for that shows robots; see :mod:`topic_scope.protocol.protocol`."""

from typing import Any, Callable, Dict, NamedTuple, Union

from topic_scope.protocol.checks import RequestError, name_of, number_of

#: Largest speed, m/s and rad/s, and coordinate, m.
_SPEED, _FAR = 100.0, 1e6


class Robots(NamedTuple):
    """Begin or end to show robots.

    :param on: whether they are to be shown
    """

    on: bool


class Steer(NamedTuple):
    """Begin or end to drive a robot.

    :param topic: where it hears commands; empty to end
    """

    topic: str


class Drive(NamedTuple):
    """Move the robot that is steered, until the next request; for a short time only.

    :param speed: forward, m/s
    :param turn: counter-clockwise, rad/s
    :param sent: when this was sent, by the page's clock, s
    """

    speed: float
    turn: float
    sent: float

    @property
    def is_stop(self) -> bool:
        """Whether the robot is to stand still."""
        return self.speed == 0.0 and self.turn == 0.0


class Goal(NamedTuple):
    """Send a robot to a place.

    :param topic: where it hears of goals
    :param frame: frame of the place
    :param x: m
    :param y: m
    :param heading: which way to look there, rad
    """

    topic: str
    frame: str
    x: float
    y: float
    heading: float


Request = Union[Robots, Steer, Drive, Goal]


def _robots(request: Dict[str, Any]) -> Robots:
    if not isinstance(request.get("on"), bool):
        raise RequestError("robots: on is true or false")
    return Robots(request["on"])


def _steer(request: Dict[str, Any]) -> Steer:
    return Steer("" if request.get("topic") == "" else name_of(request, "steer", "topic"))


def _drive(request: Dict[str, Any]) -> Drive:
    return Drive(
        number_of(request, "drive", "speed", -_SPEED, _SPEED),
        number_of(request, "drive", "turn", -_SPEED, _SPEED),
        number_of(request, "drive", "sent", 0.0, 1e12),
    )


def _goal(request: Dict[str, Any]) -> Goal:
    return Goal(
        name_of(request, "goal", "topic"),
        name_of(request, "goal", "frame"),
        *(number_of(request, "goal", key, -_FAR, _FAR) for key in ("x", "y", "heading")),
    )


READERS: Dict[str, Callable[[Dict[str, Any]], Request]] = {
    "robots": _robots,
    "steer": _steer,
    "drive": _drive,
    "goal": _goal,
}
