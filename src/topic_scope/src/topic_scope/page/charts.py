"""Feed of a page's charts: spectra, or one trace against another, in place of traces over time."""

import time
from typing import Any, Dict, Optional, Tuple

from topic_scope.analysis.decimation import as_json
from topic_scope.analysis.spectrum import peaks, reduced, spectrum
from topic_scope.analysis.xy import paired, thinned
from topic_scope.page.view import LATE_S, GapLimit, LiveView
from topic_scope.protocol.requests import Chart
from topic_scope.protocol.scaling import ReadSamples

#: Period of charts [s].
CHART_S = 0.1


class ChartFeed:
    """Producer of the charts of one page.

    :param request: the requested chart

    :ivar request: the requested chart
    """

    def __init__(self, request: Chart) -> None:
        self.request = request
        self._made_at = 0.0
        self._made_of: Any = None

    def update(
        self, now: float, read: ReadSamples, longest_step: GapLimit, view: LiveView
    ) -> Optional[Dict[str, Any]]:
        """Return the next chart; None if it is not due yet, or has not changed.

        :param now: the time [s]
        :param read: returns samples
        :param longest_step: returns the longest time between connected samples [s]
        :param view: view of the page
        """
        # By the monotonic clock: the time of the samples may stop, or be set.
        if self.request.kind == "time" or time.monotonic() < self._made_at + CHART_S:
            return None
        start, end = view.span(now)
        made_of = (start, end, tuple(view.shown), now > end + LATE_S, view.later)
        if made_of == self._made_of:
            return None
        self._made_at, self._made_of = time.monotonic(), made_of
        make = _spectra if self.request.kind == "spectrum" else _xy
        return make(read, longest_step, view, self.request, (start, end))


def _spectra(
    read: ReadSamples,
    longest_step: GapLimit,
    view: LiveView,
    request: Chart,
    span: Tuple[float, float],
) -> Dict[str, Any]:
    traces: Dict[str, Any] = {}
    for name in view.shown:
        samples = read(name, *span)
        found = spectrum(*samples, request.window, request.averages, longest_step(name))
        if found is not None:
            first, step, values = reduced(found, view.width)
            traces[name] = {
                "first": first,
                "step": step,
                "values": as_json(values),
                "peaks": peaks(found, request.window),
                "seconds": found.seconds,
            }
    return {"type": "spectrum", "traces": traces}


def _xy(
    read: ReadSamples,
    longest_step: GapLimit,
    view: LiveView,
    request: Chart,
    span: Tuple[float, float],
) -> Dict[str, Any]:
    x = read(request.x, *span)
    longest = longest_step(request.x)
    traces = {}
    for name in view.shown:
        if name != request.x:
            points = thinned(paired(x, read(name, *span), longest))
            traces[name] = [as_json(row) for row in points]
    return {"type": "xy", "x": request.x, "traces": traces}
