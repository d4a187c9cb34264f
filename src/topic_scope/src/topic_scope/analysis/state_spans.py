# Pure: knows no ROS.
"""Time spans in which a state trace (text or named value) is constant, merged if too many."""

from typing import List, NamedTuple, Optional

import numpy

#: State number of a span in which many short states were merged.
SEVERAL = -1


class StateSpan(NamedTuple):
    """Span of one state, or of many short states.

    :param start: its start [ns]
    :param end: its end [ns]; None if it continues
    :param number: number of the state; :data:`SEVERAL` for many short states
    :param states: number of states in it
    """

    start: int
    end: Optional[int]
    number: int
    states: int = 1


def state_spans(
    times: numpy.ndarray, numbers: numpy.ndarray, start: int, width: int, most: int
) -> List[StateSpan]:
    """Return the spans of a state, which holds until the next sample.

    If there are more than ``most``, spans that start within one width are merged, except the last
    of them.

    :param times: times of the samples, ascending [ns]
    :param numbers: number of the state of each; NaN if unknown
    :param start: spans that end earlier are left out [ns]
    :param width: time in which spans are merged if there are too many [ns]
    :param most: most spans that are not merged
    """
    if not len(times):
        return []
    differs = numbers[1:] != numbers[:-1]
    changes = numpy.concatenate([[0], numpy.flatnonzero(differs) + 1])
    first = max(int(times[changes].searchsorted(start, "right")) - 1, 0)
    changes = changes[first:]
    begins, states = times[changes].tolist(), numbers[changes].tolist()
    ends: List[Optional[int]] = [*begins[1:], None]
    spans = [
        StateSpan(begin, end, int(state))
        for begin, end, state in zip(begins, ends, states)
        if state == state
    ]
    return spans if len(spans) <= most else _put_together(spans, width)


def _put_together(spans: List[StateSpan], width: int) -> List[StateSpan]:
    made: List[StateSpan] = []
    group: List[StateSpan] = []
    for span, behind in zip(spans, [*spans[1:], None]):
        if behind is not None and behind.start // width == span.start // width:
            group.append(span)
            continue
        if len(group) == 1:
            made += group
        elif group:
            made.append(StateSpan(group[0].start, group[-1].end, SEVERAL, len(group)))
        made.append(span)
        group = []
    return made
