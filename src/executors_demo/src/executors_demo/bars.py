# Pure: knows no ROS.
"""Conversion of log lines to bars: start and end of each call, and overlaps between calls."""

from typing import Dict, Iterable, List, NamedTuple, Tuple

from executors_demo.events import Event


class Bar(NamedTuple):
    """A call.

    :param begin: its start since the start of the node [s]
    :param end: its end, or the time of the last line if its end is not in the log [s]
    :param thread: name of its thread
    :param who: name of the callback
    :param number: sequence number of the call, from 1
    """

    begin: float
    end: float
    thread: str
    who: str
    number: int

    def overlaps(self, other: "Bar") -> bool:
        """Return whether both ran at the same time.

        :param other: another call
        """
        return self.begin < other.end and other.begin < self.end


def bars(events: Iterable[Event]) -> List[Bar]:
    """Return the calls, in order of their start.

    :param events: of one run, in their order
    """
    begun: Dict[Tuple[str, int], Event] = {}
    made: List[Bar] = []
    last = 0.0
    for event in events:
        last = max(last, event.time)
        key = event.who, event.number
        if event.begins:
            begun[key] = event
        elif key in begun:
            made.append(_bar(begun.pop(key), event.time))
    made += [_bar(event, last) for event in begun.values()]
    return sorted(made)


def _bar(event: Event, end: float) -> Bar:
    return Bar(event.time, end, event.thread, event.who, event.number)


def overlaps(made: List[Bar], one: str, other: str) -> int:
    """Return how many pairs of calls of two callbacks ran at the same time.

    :param made: the calls
    :param one: name of a callback
    :param other: name of another, or of the same, for which each pair counts once
    """
    pairs = (
        (first, second)
        for index, first in enumerate(made)
        for second in made[index + 1 :]
        if sorted((first.who, second.who)) == sorted((one, other))
    )
    return sum(first.overlaps(second) for first, second in pairs)


def most_at_once(made: List[Bar]) -> int:
    """Return the maximum number of concurrent calls.

    :param made: the calls
    """
    # A call that ends when another begins does not overlap it.
    steps = sorted(
        [(bar.begin, 1) for bar in made if bar.begin < bar.end]
        + [(bar.end, -1) for bar in made if bar.begin < bar.end]
    )
    running = most = 0
    for _, step in steps:
        running += step
        most = max(most, running)
    return most
