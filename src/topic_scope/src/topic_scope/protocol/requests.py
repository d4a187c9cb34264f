# Pure: knows no ROS.
"""Requests of a page: one JSON object each, validated field by field.

A server has a table of handlers, with the validation and the action of each type of request.
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

#: Version of the protocol between page and scope; the page has the same number.
VERSION = 1
#: Longest accepted request [bytes].
LONGEST = 64 * 1024
#: Limits of a view: time span [s], and number of bins.
WINDOW = (1e-3, 3600.0)
WIDTH = (10, 4000)
#: Least and most parts averaged for a spectrum.
AVERAGES = (1, 64)
#: Slowest and fastest playback of a bag, relative to its recording.
SPEEDS = (0.01, 100.0)
_LARGEST_NUMBER = 2**53 - 1  # JavaScript represents integers exactly up to here
#: Times relative to a reference [s]; largest speed [m/s, rad/s]; largest coordinate [m].
_AWAY, _SPEED, _FAR = (-1e11, 1e11), 100.0, 1e6


class Handler(NamedTuple):
    """Validation and action of one type of request.

    :param check: returns the validated request; raises RequestError
    :param handle: executes it for a page; raises RequestError if that is impossible
    """

    check: Callable[[Dict[str, Any]], Any]
    handle: Callable[[Any, Any], None]


def dispatch(text: Union[str, bytes], handlers: Mapping[str, Handler], page: Any) -> None:
    """Validate and execute a request of a page.

    :param text: the received request
    :param handlers: by type of request
    :param page: the page
    :raises RequestError: if the type is unknown, or the request is invalid or cannot be
        executed
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
    """Return the names of the fields to show."""
    return fields_of(request.get("fields"))


def hidden_of(request: Dict[str, Any]) -> Tuple[str, ...]:
    """Return the names of the hidden fields, whose samples are not sent."""
    return fields_of(request.get("fields"))


class View(NamedTuple):
    """Time span to show.

    :param window: its length [s]
    :param width: number of bins
    :param end: its end [s] since the epoch; None to follow the current time
    """

    window: float
    width: int
    end: Optional[float]


def view_of(request: Dict[str, Any]) -> View:
    """Return the time span to show."""
    end = request.get("end")
    return View(
        number_of(request, "view", "window", *WINDOW),
        int(number_of(request, "view", "width", *WIDTH)),
        None if end is None else number_of(request, "view", "end", *TIMES),
    )


class Trigger(NamedTuple):
    """Trigger: show the samples around the crossing of a level.

    :param mode: off; normal, to show each crossing; auto, the same, but free-running without
        crossings; single, to stop at the next crossing
    :param field: name of the field
    :param level: the level
    :param rising: whether the level is crossed upwards
    :param number: number that the page chose for this request, repeated in the responses
    :param hysteresis: distance from the level that the trace must reach before a crossing
    :param holdoff: least time from one crossing to the next [s]
    :param position: fraction of the span before the crossing
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
    """Return the trigger of a page."""
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
    """Additional measurements, or another time span than the visible one.

    :param shapes: whether to measure times and ratios of steps and waves
    :param against: name of the reference field of phases; empty for none
    :param start: start of the span [s], relative to the reference; None for the visible span
    :param end: its end [s], relative to the reference
    :param reference: s since the epoch; None for the current time
    :param latency: whether to measure the times from stamps to receipt
    :param over_time: number of the request for statistics over time; a new number restarts them,
        0 ends them
    """

    shapes: bool = False
    against: str = ""
    start: Optional[float] = None
    end: Optional[float] = None
    reference: Optional[float] = None
    latency: bool = False
    over_time: int = 0

    def span(self, now: float) -> Optional[Tuple[float, float]]:
        """Return start and end [s]; None for the visible span."""
        if self.start is None or self.end is None:
            return None
        reference = now if self.reference is None else self.reference
        return reference + min(self.start, self.end), reference + max(self.start, self.end)


def measure_of(request: Dict[str, Any]) -> Measure:
    """Return the requested measurements."""
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
    """Chart of the traces.

    :param kind: time; spectrum; xy, one trace against another
    :param x: name of the horizontal field, for xy
    :param window: window of a spectrum
    :param averages: number of parts that a spectrum averages
    """

    kind: str = "time"
    x: str = ""
    window: str = "hann"
    averages: int = 1


def chart_of(request: Dict[str, Any]) -> Chart:
    """Return the requested chart."""
    kind = word_of(request, "chart", "kind", ("time", "spectrum", "xy"))
    if kind == "xy":
        return Chart(kind, field_in(request, "chart", "x"))
    if kind == "time":
        return Chart()
    window = word_of(request, "chart", "window", tuple(WINDOWS))
    return Chart(kind, "", window, int(number_of(request, "chart", "averages", *AVERAGES)))


# --- The graph -----------------------------------------------------------------------------------


def graph_of(request: Dict[str, Any]) -> bool:
    """Return whether to show the graph."""
    return flag_of(request, "graph", "on")


class SetParameter(NamedTuple):
    """Set a parameter.

    :param node: namespace of the parameter
    :param name: name in the namespace
    :param value: the received value
    """

    node: str
    name: str
    value: Any


def set_of(request: Dict[str, Any]) -> SetParameter:
    """Return the parameter to set, and its value."""
    if "value" not in request:
        raise RequestError("set: missing value")
    value = request["value"]
    if not isinstance(value, (bool, int, float, str)):
        raise RequestError("set: the value must be a number, a string or a Boolean")
    return SetParameter(name_of(request, "set", "node"), name_of(request, "set", "name"), value)


class CallService(NamedTuple):
    """Call a service.

    :param service: its name
    :param data: for a service that takes a Boolean
    """

    service: str
    data: Optional[bool]


def call_of(request: Dict[str, Any]) -> CallService:
    """Return the service to call."""
    data = None if request.get("data") is None else flag_of(request, "call", "data")
    return CallService(name_of(request, "call", "service"), data)


class Transition(NamedTuple):
    """Ask a managed node for a transition.

    :param node: its name
    :param label: name of the transition
    """

    node: str
    label: str


def transition_of(request: Dict[str, Any]) -> Transition:
    """Return the node and the requested transition."""
    kind = "transition"
    return Transition(name_of(request, kind, "node"), name_of(request, kind, "label"))


# --- Robots --------------------------------------------------------------------------------------


def robots_of(request: Dict[str, Any]) -> bool:
    """Return whether to show robots."""
    return flag_of(request, "robots", "on")


def steering_of(request: Dict[str, Any]) -> str:
    """Return the command topic of the robot to drive; empty for none."""
    return "" if request.get("topic") == "" else name_of(request, "steer", "topic")


class Drive(NamedTuple):
    """Command of the driven robot until the next request, for a short time only.

    :param speed: forward [m/s]
    :param turn: counter-clockwise [rad/s]
    :param sent: time of sending, by the page's clock [s]
    """

    speed: float
    turn: float
    sent: float

    @property
    def is_stop(self) -> bool:
        """Whether the command stops the robot."""
        return self.speed == 0.0 and self.turn == 0.0


def drive_of(request: Dict[str, Any]) -> Drive:
    """Return the requested motion of the robot."""
    return Drive(
        number_of(request, "drive", "speed", -_SPEED, _SPEED),
        number_of(request, "drive", "turn", -_SPEED, _SPEED),
        number_of(request, "drive", "sent", 0.0, 1e12),
    )


class Goal(NamedTuple):
    """Goal pose of a robot.

    :param topic: topic of its goals
    :param frame: frame of the pose
    :param x: m
    :param y: m
    :param heading: heading at the goal [rad]
    """

    topic: str
    frame: str
    x: float
    y: float
    heading: float


def goal_of(request: Dict[str, Any]) -> Goal:
    """Return the requested goal."""
    x, y, heading = (number_of(request, "goal", key, -_FAR, _FAR) for key in ("x", "y", "heading"))
    topic, frame = (name_of(request, "goal", key) for key in ("topic", "frame"))
    return Goal(topic, frame, x, y, heading)


# --- A bag ---------------------------------------------------------------------------------------


class Playback(NamedTuple):
    """Change of the playback of a bag; None leaves a value unchanged.

    :param playing: whether its clock runs
    :param time: time to jump to [s] since the epoch
    :param speed: factor relative to the recording
    """

    playing: Optional[bool] = None
    time: Optional[float] = None
    speed: Optional[float] = None


def playback_of(request: Dict[str, Any]) -> Playback:
    """Return the requested playback."""
    kind = "playback"
    playing = None if request.get("playing") is None else flag_of(request, kind, "playing")
    time, speed = (
        None if request.get(key) is None else number_of(request, kind, key, *limits)
        for key, limits in (("time", TIMES), ("speed", SPEEDS))
    )
    return Playback(playing, time, speed)
