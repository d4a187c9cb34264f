# Pure: knows no ROS.
"""Requests of a page: one JSON object each, validated field by field.

A server of pages has a table of handlers, with the check and the action of each type of request.
"""

import json
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional, Tuple, Union

from topic_scope.analysis.spectrum import WINDOWS
from topic_scope.protocol.checks import (
    TIMES,
    RequestError,
    field_in,
    fields_of,
    flag_of,
    name_of,
    number_of,
    word_of,
)

#: Version of all that page and scope say to each other; the page has the same number.
VERSION = 1
#: Longest request that is read [bytes].
LONGEST = 64 * 1024
#: Limits of a view: time span [s], and number of bins.
WINDOW = (1e-3, 3600.0)
WIDTH = (10, 4000)
#: Least and most parts that a spectrum is the mean of.
AVERAGES = (1, 64)
#: How much slower and faster than it was recorded a bag may be played.
SPEEDS = (0.01, 100.0)
_LARGEST_NUMBER = 2**53 - 1  # all integers up to here are exact in a page
#: Times from a reference on [s]; largest speed, m/s and rad/s; and coordinate [m].
_AWAY, _SPEED, _FAR = (-1e11, 1e11), 100.0, 1e6


class Handler(NamedTuple):
    """Validation and handling of one type of request.

    :param check: returns what is asked for; raises RequestError
    :param handle: does it for a page; raises RequestError if that cannot be done
    """

    check: Callable[[Dict[str, Any]], Any]
    handle: Callable[[Any, Any], None]


def dispatch(text: Union[str, bytes], handlers: Mapping[str, Handler], page: Any) -> None:
    """Handle a request of a page.

    :param text: the request as it came
    :param handlers: by type of request
    :param page: the page
    :raises RequestError: if the type is unknown, something in the request is not allowed, or it
        cannot be done
    """
    if not isinstance(text, str):
        raise RequestError("a request must be text")
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise RequestError("a request must be a JSON object") from None
    if not isinstance(request, dict):
        raise RequestError("a request must be a JSON object")
    kind = request.get("type")
    handler = handlers.get(kind) if isinstance(kind, str) else None
    if handler is None:
        raise RequestError("unknown type of request; known are " + ", ".join(handlers))
    handler.handle(page, handler.check(request))


# --- Traces --------------------------------------------------------------------------------------


def selection_of(request: Dict[str, Any]) -> Tuple[str, ...]:
    """Return the names of the fields that are to be shown."""
    return fields_of(request.get("fields"))


def hidden_of(request: Dict[str, Any]) -> Tuple[str, ...]:
    """Return the names of the fields of which nothing is to be sent for now."""
    return fields_of(request.get("fields"))


class View(NamedTuple):
    """Show this span of time.

    :param window: how long it is [s]
    :param width: how many bins it is shown in
    :param end: its end [s] since the epoch; None to go with the time
    """

    window: float
    width: int
    end: Optional[float]


def view_of(request: Dict[str, Any]) -> View:
    """Return which span of time is to be shown."""
    end = request.get("end")
    return View(
        number_of(request, "view", "window", *WINDOW),
        int(number_of(request, "view", "width", *WIDTH)),
        None if end is None else number_of(request, "view", "end", *TIMES),
    )


class Trigger(NamedTuple):
    """Show what is around the crossing of a level.

    :param mode: off; normal, to show each crossing; auto, the same, but to go on where none comes;
        single, to stop at the next one
    :param field: name of the field
    :param level: the level
    :param rising: whether it is crossed upwards
    :param number: the page's own, by which it knows what is told of this request
    :param hysteresis: how far beyond the level the trace has to be before it crosses it
    :param holdoff: least time from one crossing to the next [s]
    :param position: which part of the span lies before the crossing
    """

    mode: str
    field: str
    level: float
    rising: bool
    number: int = 0
    hysteresis: float = 0.0
    holdoff: float = 0.0
    position: float = 0.5


def trigger_of(request: Dict[str, Any]) -> Trigger:
    """Return what a page is to wait for."""
    mode = word_of(request, "trigger", "mode", ("off", "normal", "auto", "single"))
    number = 0
    if "number" in request:
        number = int(number_of(request, "trigger", "number", 0, _LARGEST_NUMBER))
    if mode == "off":
        return Trigger(mode, "", 0.0, True, number)
    field = field_in(request, "trigger")
    level = number_of(request, "trigger", "level", -1e300, 1e300)
    rising = word_of(request, "trigger", "edge", ("rising", "falling")) == "rising"
    hysteresis, holdoff, position = (
        number_of(request, "trigger", key, 0.0, most) if key in request else default
        for key, most, default in (
            ("hysteresis", 1e300, 0.0),
            ("holdoff", WINDOW[1], 0.0),
            ("position", 1.0, 0.5),
        )
    )
    return Trigger(mode, field, level, rising, number, hysteresis, holdoff, position)


class Measure(NamedTuple):
    """Measure more of the traces, or another span of time than the one that is visible.

    :param shapes: whether times and ratios of steps and waves are wanted
    :param against: name of the field that phases are against; empty for none
    :param start: start of the span [s] from the reference on; None for what is visible
    :param end: its end [s] from the reference on
    :param reference: s since the epoch; None to go with the time
    :param latency: whether the times from stamps to reception are wanted
    :param over_time: number of the request to count how figures vary; another one restarts it, 0
        ends it
    """

    shapes: bool = False
    against: str = ""
    start: Optional[float] = None
    end: Optional[float] = None
    reference: Optional[float] = None
    latency: bool = False
    over_time: int = 0

    def span(self, now: float) -> Optional[Tuple[float, float]]:
        """Return begin and end [s]; None for what is visible."""
        if self.start is None or self.end is None:
            return None
        reference = now if self.reference is None else self.reference
        return reference + min(self.start, self.end), reference + max(self.start, self.end)


def measure_of(request: Dict[str, Any]) -> Measure:
    """Return what is to be measured."""
    shapes = "shapes" in request and flag_of(request, "measure", "shapes")
    start, end, reference = (
        None if request.get(key) is None else number_of(request, "measure", key, *limits)
        for key, limits in (("start", _AWAY), ("end", _AWAY), ("reference", TIMES))
    )
    against = field_in(request, "measure", "against") if request.get("against") else ""
    latency = "latency" in request and flag_of(request, "measure", "latency")
    over_time = 0
    if "over_time" in request:
        over_time = int(number_of(request, "measure", "over_time", 0, _LARGEST_NUMBER))
    return Measure(shapes, against, start, end, reference, latency, over_time)


class Chart(NamedTuple):
    """Show the traces otherwise than over time.

    :param kind: time; spectrum; xy, one over another
    :param x: name of the field that goes to the right, of the kind xy
    :param window: window of a spectrum
    :param averages: of how many parts a spectrum is the mean
    """

    kind: str = "time"
    x: str = ""
    window: str = "hann"
    averages: int = 1


def chart_of(request: Dict[str, Any]) -> Chart:
    """Return which chart is wanted."""
    kind = word_of(request, "chart", "kind", ("time", "spectrum", "xy"))
    if kind == "xy":
        return Chart(kind, field_in(request, "chart", "x"))
    if kind == "time":
        return Chart()
    window = word_of(request, "chart", "window", tuple(WINDOWS))
    return Chart(kind, "", window, int(number_of(request, "chart", "averages", *AVERAGES)))


# --- The graph -----------------------------------------------------------------------------------


def graph_of(request: Dict[str, Any]) -> bool:
    """Return whether the graph is to be shown."""
    return flag_of(request, "graph", "on")


class Set(NamedTuple):
    """Set a parameter.

    :param node: namespace of the parameter
    :param name: name in there
    :param value: as it came
    """

    node: str
    name: str
    value: Any


def set_of(request: Dict[str, Any]) -> Set:
    """Return which parameter is to be set, and to what."""
    if "value" not in request:
        raise RequestError("set: there is no value")
    value = request["value"]
    if not isinstance(value, (bool, int, float, str)):
        raise RequestError("set: the value must be a number, a text or a truth value")
    return Set(name_of(request, "set", "node"), name_of(request, "set", "name"), value)


class Call(NamedTuple):
    """Call a service.

    :param service: its name
    :param data: for one that takes a truth value
    """

    service: str
    data: Optional[bool]


def call_of(request: Dict[str, Any]) -> Call:
    """Return which service is to be called."""
    data = None if request.get("data") is None else flag_of(request, "call", "data")
    return Call(name_of(request, "call", "service"), data)


class Transition(NamedTuple):
    """Ask a managed node for a transition.

    :param node: its name
    :param label: name of the transition
    """

    node: str
    label: str


def transition_of(request: Dict[str, Any]) -> Transition:
    """Return which node is to make which transition."""
    kind = "transition"
    return Transition(name_of(request, kind, "node"), name_of(request, kind, "label"))


# --- Robots --------------------------------------------------------------------------------------


def robots_of(request: Dict[str, Any]) -> bool:
    """Return whether robots are to be shown."""
    return flag_of(request, "robots", "on")


def steering_of(request: Dict[str, Any]) -> str:
    """Return the topic of the robot's commands that is to be driven; empty for none."""
    return "" if request.get("topic") == "" else name_of(request, "steer", "topic")


class Drive(NamedTuple):
    """Move the robot that is steered, until the next request; for a short time only.

    :param speed: forward [m/s]
    :param turn: counter-clockwise [rad/s]
    :param sent: when this was sent, by the page's clock [s]
    """

    speed: float
    turn: float
    sent: float

    @property
    def is_stop(self) -> bool:
        """Whether the command stops the robot."""
        return self.speed == 0.0 and self.turn == 0.0


def drive_of(request: Dict[str, Any]) -> Drive:
    """Return how the robot is to move."""
    return Drive(
        number_of(request, "drive", "speed", -_SPEED, _SPEED),
        number_of(request, "drive", "turn", -_SPEED, _SPEED),
        number_of(request, "drive", "sent", 0.0, 1e12),
    )


class Goal(NamedTuple):
    """Send a robot to a place.

    :param topic: where it takes goals
    :param frame: frame of the place
    :param x: m
    :param y: m
    :param heading: which way to look there [rad]
    """

    topic: str
    frame: str
    x: float
    y: float
    heading: float


def goal_of(request: Dict[str, Any]) -> Goal:
    """Return where a robot is to go."""
    x, y, heading = (number_of(request, "goal", key, -_FAR, _FAR) for key in ("x", "y", "heading"))
    topic, frame = (name_of(request, "goal", key) for key in ("topic", "frame"))
    return Goal(topic, frame, x, y, heading)


# --- A bag ---------------------------------------------------------------------------------------


class Playback(NamedTuple):
    """Play a bag otherwise; what is None stays as it is.

    :param playing: whether its clock goes
    :param time: where to go to [s] since the epoch
    :param speed: how much faster than it was recorded
    """

    playing: Optional[bool] = None
    time: Optional[float] = None
    speed: Optional[float] = None


def playback_of(request: Dict[str, Any]) -> Playback:
    """Return how a bag is to be played."""
    kind = "playback"
    playing = None if request.get("playing") is None else flag_of(request, kind, "playing")
    time, speed = (
        None if request.get(key) is None else number_of(request, kind, key, *limits)
        for key, limits in (("time", TIMES), ("speed", SPEEDS))
    )
    return Playback(playing, time, speed)
