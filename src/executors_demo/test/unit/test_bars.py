"""From lines to bars."""

from typing import List, Tuple

from executors_demo.bars import Bar, bars, most_at_once, overlaps
from executors_demo.events import Event
from hypothesis import given
from hypothesis import strategies as st

#: Begin and length of calls, in whole seconds.
CALLS = st.lists(st.tuples(st.integers(0, 20), st.integers(1, 5)), max_size=12)


def bar(begin: float, end: float, who: str = "timer1", number: int = 1) -> Bar:
    return Bar(begin, end, "executor-1-1", who, number)


def events_of(calls: List[Tuple[int, int]]) -> List[Event]:
    """Return the log of calls, each on its own thread."""
    events = []
    for number, (begin, length) in enumerate(calls, 1):
        events.append(Event(begin, f"thread{number}", "job", number, True))
        events.append(Event(begin + length, f"thread{number}", "job", number, False))
    return sorted(events, key=lambda event: event.time)


@given(CALLS)
def test_each_call_is_a_bar(calls: List[Tuple[int, int]]) -> None:
    made = bars(events_of(calls))
    assert sorted((one.begin, one.end) for one in made) == sorted(
        (begin, begin + length) for begin, length in calls
    )
    assert made == sorted(made)


@given(CALLS)
def test_concurrent_calls_are_counted(calls: List[Tuple[int, int]]) -> None:
    made = bars(events_of(calls))
    seconds = [
        sum(begin <= second < begin + length for begin, length in calls) for second in range(26)
    ]
    assert most_at_once(made) == max(seconds)
    pairs = [
        (one, other)
        for one in range(len(calls))
        for other in range(one)
        if set(range(calls[one][0], sum(calls[one])))
        & set(range(calls[other][0], sum(calls[other])))
    ]
    assert overlaps(made, "job", "job") == len(pairs)


def test_a_call_that_has_not_ended_lasts_to_the_last_line() -> None:
    events = [
        Event(1.0, "executor-1-1", "timer1", 1, True),
        Event(2.0, "executor-1-2", "timer2", 1, True),
        Event(5.0, "executor-1-2", "timer2", 1, False),
    ]
    assert bars(events)[0] == bar(1.0, 5.0)


def test_an_end_without_its_begin_is_left_out() -> None:
    assert bars([Event(1.0, "executor-1-1", "timer1", 7, False)]) == []


def test_adjacent_calls_do_not_overlap() -> None:
    one, other = bar(0.0, 1.0), bar(1.0, 2.0, "timer2")
    assert not one.overlaps(other) and not other.overlaps(one)
    assert most_at_once([one, other]) == 1


def test_call_of_zero_length_overlaps_enclosing_call() -> None:
    one, other = bar(0.0, 1.0), bar(0.5, 0.5, "timer2")
    assert one.overlaps(other) and other.overlaps(one)
    assert overlaps([one, other], "timer2", "timer1") == 1


def test_only_the_two_that_are_asked_for_are_counted() -> None:
    made = [bar(0.0, 3.0), bar(1.0, 2.0, "timer2"), bar(1.0, 2.0, "timer1", 2)]
    assert overlaps(made, "timer1", "timer2") == 2
    assert overlaps(made, "timer1", "timer1") == 1
    assert overlaps(made, "timer2", "timer2") == 0
