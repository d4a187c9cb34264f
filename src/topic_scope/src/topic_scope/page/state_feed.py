"""The states that a page shows over time, as messages to it."""

import math
import time
from typing import Any, Dict, List, Optional

from topic_scope.analysis.state_spans import SEVERAL, state_spans
from topic_scope.page.view import LATE_S, LiveView
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, to_ns

#: Time between two messages [s].
_STATES_S = 0.1
#: Most spans of a trace that are sent one by one.
_SPANS = 400


class StateFeed:
    """Makes the messages about the states of one page."""

    def __init__(self) -> None:
        self._made_at = 0.0
        self._made_of: Any = None

    def update(self, recorder: Recorder, view: LiveView, now: float) -> Optional[Dict[str, Any]]:
        """Return what is to be shown; None where it is not time yet, or the same as before.

        :param recorder: has the samples
        :param view: what the page shows
        :param now: the time up to which samples are there [s]
        """
        names = view.states
        # Not by the time of the samples, which may stand, or be set.
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
        # What was before the first sample is not known.
        "earlier": bool(spans) and spans[0].start == int(times[0]),
    }
