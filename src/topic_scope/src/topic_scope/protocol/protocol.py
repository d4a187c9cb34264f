"""What a page may ask for: one JSON object a request, checked field by field."""

import json
from typing import Any, Callable, Dict, NamedTuple, Optional, Tuple, Union

from topic_scope.protocol import playback, robot_requests
from topic_scope.protocol.checks import (
    TIMES,
    RequestError,
    field_in,
    fields_of,
    name_of,
    number_of,
    word_of,
)
from topic_scope.protocol.looks import Looks, looks_of
from topic_scope.protocol.wishes import Chart, Measure, chart_of, measure_of

#: Longest request that is read, bytes.
LONGEST = 64 * 1024
#: Limits of a view: time span, s, and number of bins.
WINDOW = (1e-3, 3600.0)
WIDTH = (10, 4000)
_LARGEST_NUMBER = 2**53 - 1  # all integers up to here are exact in a page


class Select(NamedTuple):
    """Show these fields.

    :param fields: their names
    """

    fields: Tuple[str, ...]


class View(NamedTuple):
    """Show this span of time.

    :param window: how long it is, s
    :param width: how many bins it is shown in
    :param end: its end, s since the epoch; None to go with the time
    """

    window: float
    width: int
    end: Optional[float]


class Trigger(NamedTuple):
    """Show what is around the crossing of a level.

    :param mode: off; normal, to show each crossing; auto, the same, but to go on where none comes;
        single, to stop at the next one
    :param field: name of the field
    :param level: the level
    :param rising: whether it is crossed upwards
    :param number: the page's own, by which it knows what is told of this request
    :param hysteresis: how far beyond the level the trace has to be before it crosses it
    :param holdoff: least time from one crossing to the next, s
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


class Set(NamedTuple):
    """Set a parameter.

    :param node: namespace of the parameter
    :param name: name in there
    :param value: as it came
    """

    node: str
    name: str
    value: Any


class Call(NamedTuple):
    """Call a service.

    :param service: its name
    :param data: for one that takes a truth value
    """

    service: str
    data: Optional[bool]


class Transit(NamedTuple):
    """Ask a managed node for a transition.

    :param node: its name
    :param label: name of the transition
    """

    node: str
    label: str


class Graph(NamedTuple):
    """Begin or end to show the graph.

    :param on: whether it is to be shown
    """

    on: bool


Request = Union[
    Select,
    View,
    Trigger,
    Looks,
    Measure,
    Chart,
    Set,
    Call,
    Transit,
    Graph,
    robot_requests.Request,
    playback.Playback,
]


def parse(text: Union[str, bytes]) -> Request:
    """Read a request.

    :param text: as it came
    :raises RequestError: if it is none that is known, or something in it is not allowed
    """
    if not isinstance(text, str):
        raise RequestError("a request is text")
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise RequestError("a request is a JSON object") from None
    if not isinstance(request, dict):
        raise RequestError("a request is a JSON object")
    kind = request.get("type")
    reader = _READERS.get(kind) if isinstance(kind, str) else None
    if reader is None:
        raise RequestError("there is no request of this type; there are " + ", ".join(_READERS))
    return reader(request)


def _select(request: Dict[str, Any]) -> Select:
    return Select(fields_of(request.get("fields")))


def _view(request: Dict[str, Any]) -> View:
    end = request.get("end")
    return View(
        number_of(request, "view", "window", *WINDOW),
        int(number_of(request, "view", "width", *WIDTH)),
        None if end is None else number_of(request, "view", "end", *TIMES),
    )


def _trigger(request: Dict[str, Any]) -> Trigger:
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


def _set(request: Dict[str, Any]) -> Set:
    if "value" not in request:
        raise RequestError("set: a value is needed")
    value = request["value"]
    if not isinstance(value, (bool, int, float, str)):
        raise RequestError("set: a value is a number, a text or a truth value")
    return Set(name_of(request, "set", "node"), name_of(request, "set", "name"), value)


def _call(request: Dict[str, Any]) -> Call:
    data = request.get("data")
    if data is not None and not isinstance(data, bool):
        raise RequestError("call: data is true or false")
    return Call(name_of(request, "call", "service"), data)


def _transit(request: Dict[str, Any]) -> Transit:
    return Transit(name_of(request, "transit", "node"), name_of(request, "transit", "label"))


def _graph(request: Dict[str, Any]) -> Graph:
    if not isinstance(request.get("on"), bool):
        raise RequestError("graph: on is true or false")
    return Graph(request["on"])


_READERS: Dict[str, Callable[[Dict[str, Any]], Request]] = {
    "select": _select,
    "view": _view,
    "trigger": _trigger,
    "looks": looks_of,
    "measure": measure_of,
    "chart": chart_of,
    "set": _set,
    "call": _call,
    "transit": _transit,
    "graph": _graph,
    **robot_requests.READERS,
    **playback.READERS,
}
