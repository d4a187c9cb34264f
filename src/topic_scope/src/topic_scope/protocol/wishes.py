"""What a page wants to know of its traces, besides seeing them over time."""

from typing import Any, Dict, NamedTuple, Optional, Tuple

from topic_scope.analysis.spectrum import WINDOWS
from topic_scope.protocol.checks import TIMES, RequestError, field_in, number_of, word_of

#: Least and most parts that a spectrum is the mean of.
AVERAGES = (1, 64)
_AWAY = (-1e11, 1e11)


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


def measure_of(request: Dict[str, Any]) -> Measure:
    """Read what is to be measured.

    :param request: as it came
    :raises RequestError: if something in it is not allowed
    """
    shapes = request.get("shapes", False)
    if not isinstance(shapes, bool):
        raise RequestError("measure: shapes is true or false")
    start, end, reference = (
        None if request.get(key) is None else number_of(request, "measure", key, *limits)
        for key, limits in (("start", _AWAY), ("end", _AWAY), ("reference", TIMES))
    )
    against = field_in(request, "measure", "against") if request.get("against") else ""
    return Measure(shapes, against, start, end, reference)


def chart_of(request: Dict[str, Any]) -> Chart:
    """Read which chart is wanted.

    :param request: as it came
    :raises RequestError: if something in it is not allowed
    """
    kind = word_of(request, "chart", "kind", ("time", "spectrum", "xy"))
    if kind == "xy":
        return Chart(kind, field_in(request, "chart", "x"))
    if kind == "time":
        return Chart()
    window = word_of(request, "chart", "window", tuple(WINDOWS))
    return Chart(kind, "", window, int(number_of(request, "chart", "averages", *AVERAGES)))
