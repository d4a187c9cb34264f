"""What a page shows in place of traces over time: their spectra, or one over another."""

import time
from typing import Any, Dict, Optional

from topic_scope.decimation import as_json
from topic_scope.recorder import Recorder
from topic_scope.spectrum import peaks, reduced, spectrum
from topic_scope.view import LATE_S, LiveView
from topic_scope.wishes import Chart
from topic_scope.xy import paired, thinned

#: Time between two charts, s.
CHART_S = 0.1


class ChartFeed:
    """Makes the charts of one page.

    :param request: which kind
    """

    def __init__(self, request: Chart) -> None:
        self._request = request
        self._made_at = 0.0
        self._made_of: Any = None

    def update(self, now: float, recorder: Recorder, view: LiveView) -> Optional[Dict[str, Any]]:
        """Return what is to be shown, None where it is not time yet, or the same as before.

        :param now: the time, s
        :param recorder: has the samples
        :param view: what the page shows
        """
        # Not by the time of the samples, which may stand, or be set.
        if self._request.kind == "time" or time.monotonic() < self._made_at + CHART_S:
            return None
        start, end = view.span(now)
        made_of = (start, end, tuple(view.fields), now > end + LATE_S)
        if made_of == self._made_of:
            return None
        self._made_at, self._made_of = time.monotonic(), made_of
        make = _spectra if self._request.kind == "spectrum" else _xy
        return make(recorder, view, self._request, start, end)


def _spectra(
    recorder: Recorder, view: LiveView, request: Chart, start: float, end: float
) -> Dict[str, Any]:
    traces: Dict[str, Any] = {}
    for name in view.fields:
        samples, longest = recorder.samples(name, start, end), recorder.longest_step(name)
        found = spectrum(*samples, request.window, request.averages, longest)
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
    recorder: Recorder, view: LiveView, request: Chart, start: float, end: float
) -> Dict[str, Any]:
    x = recorder.samples(request.x, start, end)
    longest = recorder.longest_step(request.x)
    traces = {}
    for name in view.fields:
        if name != request.x:
            points = thinned(paired(x, recorder.samples(name, start, end), longest))
            traces[name] = [as_json(row) for row in points]
    return {"type": "xy", "x": request.x, "traces": traces}
