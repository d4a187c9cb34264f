# Pure: knows no ROS.
"""Spans of time in which a state is the same."""

from typing import List, NamedTuple, Optional

import numpy

#: What stands for the number of a state where many change in a short time.
SEVERAL = -1


class StateSpan(NamedTuple):
    """A span with one state, or with many short ones.

    :param start: its start [ns]
    :param end: its end [ns]; None where it goes on
    :param number: number of the state; :data:`SEVERAL` for many short ones
    :param states: how many there are in it
    """

    start: int
    end: Optional[int]
    number: int
    states: int = 1


def state_spans(
    times: numpy.ndarray, numbers: numpy.ndarray, start: int, width: int, most: int
) -> List[StateSpan]:
    """Return the spans of a state that holds until the next sample.

    Where more than some are to be seen, those that begin within one width are put together, but for
    the last of them.

    :param times: when samples were taken, ascending [ns]
    :param numbers: number of the state of each; NaN where it is not known
    :param start: spans that end before are left out [ns]
    :param width: what is put together where they are too many [ns]
    :param most: from how many on
    """
    if not len(times):
        return []
    differs = numbers[1:] != numbers[:-1]
    differs &= ~(numpy.isnan(numbers[1:]) & numpy.isnan(numbers[:-1]))
    changes = numpy.concatenate([[0], numpy.flatnonzero(differs) + 1])
    first = max(int(times[changes].searchsorted(start, "right")) - 1, 0)
    changes = changes[first:]
    begins, kinds = times[changes].tolist(), numbers[changes].tolist()
    ends: List[Optional[int]] = [*begins[1:], None]
    spans = [
        StateSpan(begin, end, int(kind))
        for begin, end, kind in zip(begins, ends, kinds)
        if kind == kind
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
