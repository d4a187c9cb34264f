"""What a page may ask for: one JSON object a request, checked field by field."""

import json
from typing import Any, Callable, Dict, NamedTuple, Optional, Tuple, Union

from topic_scope.checks import (
    TIMES,
    RequestError,
    field_in,
    fields_of,
    name_in,
    number_in,
    word_in,
)
from topic_scope.spectrum import WINDOWS

#: Longest request that is read, bytes.
LONGEST = 64 * 1024
#: Limits of a view: time span, s, and number of bins.
WINDOW = (1e-3, 3600.0)
WIDTH = (10, 4000)
#: Least and most parts that a spectrum is the mean of.
AVERAGES = (1, 64)
_AWAY = (-1e11, 1e11)
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

    :param mode: off; normal, to show each crossing; single, to stop at the next one
    :param field: name of the field
    :param level: the level
    :param rising: whether it is crossed upwards
    :param number: the page's own, by which it knows what is told of this request
    """

    mode: str
    field: str
    level: float
    rising: bool
    number: int = 0


class Measure(NamedTuple):
    """Measure more of the traces, or another span of time than the one that is visible.

    :param shapes: whether times and ratios of steps and waves are wanted
    :param against: name of the field that phases are against; empty for none
    :param start: begin of the span, s from the reference on; None for what is visible
    :param end: its end, s from the reference on
    :param reference: s since the epoch; None to go with the time
    """

    shapes: bool = False
    against: str = ""
    start: Optional[float] = None
    end: Optional[float] = None
    reference: Optional[float] = None

    def span(self, now: float) -> Optional[Tuple[float, float]]:
        """Return begin and end, s; None for what is visible."""
        if self.start is None or self.end is None:
            return None
        reference = now if self.reference is None else self.reference
        return reference + min(self.start, self.end), reference + max(self.start, self.end)


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


class Graph(NamedTuple):
    """Begin or end to show the graph.

    :param on: whether it is to be shown
    """

    on: bool


Request = Union[Select, View, Trigger, Measure, Chart, Set, Call, Graph]


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
        number_in(request, "view", "window", *WINDOW),
        int(number_in(request, "view", "width", *WIDTH)),
        None if end is None else number_in(request, "view", "end", *TIMES),
    )


def _trigger(request: Dict[str, Any]) -> Trigger:
    mode = word_in(request, "trigger", "mode", ("off", "normal", "single"))
    number = 0
    if "number" in request:
        number = int(number_in(request, "trigger", "number", 0, _LARGEST_NUMBER))
    if mode == "off":
        return Trigger(mode, "", 0.0, True, number)
    field = field_in(request, "trigger")
    level = number_in(request, "trigger", "level", -1e300, 1e300)
    rising = word_in(request, "trigger", "edge", ("rising", "falling")) == "rising"
    return Trigger(mode, field, level, rising, number)


def _measure(request: Dict[str, Any]) -> Measure:
    shapes = request.get("shapes", False)
    if not isinstance(shapes, bool):
        raise RequestError("measure: shapes is true or false")
    start, end, reference = (
        None if request.get(key) is None else number_in(request, "measure", key, *limits)
        for key, limits in (("start", _AWAY), ("end", _AWAY), ("reference", TIMES))
    )
    against = field_in(request, "measure", "against") if request.get("against") else ""
    return Measure(shapes, against, start, end, reference)


def _chart(request: Dict[str, Any]) -> Chart:
    kind = word_in(request, "chart", "kind", ("time", "spectrum", "xy"))
    if kind == "xy":
        return Chart(kind, field_in(request, "chart", "x"))
    if kind == "time":
        return Chart()
    window = word_in(request, "chart", "window", tuple(WINDOWS))
    return Chart(kind, "", window, int(number_in(request, "chart", "averages", *AVERAGES)))


def _set(request: Dict[str, Any]) -> Set:
    if "value" not in request:
        raise RequestError("set: a value is needed")
    value = request["value"]
    if not isinstance(value, (bool, int, float, str)):
        raise RequestError("set: a value is a number, a text or a truth value")
    return Set(name_in(request, "set", "node"), name_in(request, "set", "name"), value)


def _call(request: Dict[str, Any]) -> Call:
    data = request.get("data")
    if data is not None and not isinstance(data, bool):
        raise RequestError("call: data is true or false")
    return Call(name_in(request, "call", "service"), data)


def _graph(request: Dict[str, Any]) -> Graph:
    if not isinstance(request.get("on"), bool):
        raise RequestError("graph: on is true or false")
    return Graph(request["on"])


_READERS: Dict[str, Callable[[Dict[str, Any]], Request]] = {
    "select": _select,
    "view": _view,
    "trigger": _trigger,
    "measure": _measure,
    "chart": _chart,
    "set": _set,
    "call": _call,
    "graph": _graph,
}
