"""Feed of a page's state traces: texts and named values, as spans over time."""

import math
import time
from typing import Any, Dict, List, Optional

from topic_scope.analysis.state_spans import SEVERAL, state_spans
from topic_scope.page.view import LATE_S, LiveView
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, to_ns

#: Period of messages [s].
_STATES_S = 0.1
#: Most spans of a trace that are sent individually.
_SPANS = 400


class StateFeed:
    """Producer of the state messages of one page."""

    def __init__(self) -> None:
        self._made_at = 0.0
        self._made_of: Any = None

    def update(self, recorder: Recorder, view: LiveView, now: float) -> Optional[Dict[str, Any]]:
        """Return the next message; None if it is not due yet, or has not changed.

        :param recorder: recorder of the samples
        :param view: view of the page
        :param now: time up to which samples are complete [s]
        """
        names = view.states
        # By the monotonic clock: the time of the samples may stop, or be set.
        if not names or time.monotonic() < self._made_at + _STATES_S:
            return None
        start, end = view.span(now)
        made_of = (start, end, tuple(names), now > end + LATE_S, view.later)
        if made_of == self._made_of:
            return None
        self._made_at, self._made_of = time.monotonic(), made_of
        known = min(now, end)
        traces = {name: _spans_of(recorder, name, start, known, view) for name in names}
        return {"type": "states", "until": known, "traces": traces}


def _spans_of(
    recorder: Recorder, name: str, start: float, end: float, view: LiveView
) -> Dict[str, Any]:
    trace = recorder.trace(name)
    if trace is None or trace.states is None:
        return {"texts": [], "spans": []}
    times, numbers, _ = trace.rows(to_ns(-math.inf), to_ns(end))
    width = max(to_ns(view.window / _SPANS), 1)
    spans = state_spans(times, numbers, to_ns(start), width, _SPANS)
    used = sorted({span.number for span in spans} - {SEVERAL})
    places = {number: place for place, number in enumerate(used)}
    rows: List[List[Any]] = [
        [
            span.start / NS,
            None if span.end is None else span.end / NS,
            places.get(span.number, SEVERAL),
            span.states,
        ]
        for span in spans
    ]
    return {
        "texts": [trace.states.texts[number] for number in used],
        "spans": rows,
        # The state before the first sample is unknown.
        "earlier": bool(spans) and spans[0].start == int(times[0]),
    }
