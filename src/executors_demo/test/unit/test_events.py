"""Printed events can be parsed again."""

from typing import List

import pytest
from executors_demo.events import Event, read
from hypothesis import given
from hypothesis import strategies as st

WORDS = st.from_regex(r"[a-z_/]{1,12}[0-9-]{0,3}", fullmatch=True)
NOTES = st.text(st.characters(min_codepoint=33, max_codepoint=0x2FF), max_size=20)
EVENTS = st.builds(
    Event,
    st.integers(0, 10**8).map(lambda milliseconds: milliseconds / 1000.0),
    WORDS,
    WORDS,
    st.integers(1, 10**6),
    st.booleans(),
    NOTES.map(lambda text: "".join(text.split())),
)


@given(st.lists(EVENTS, max_size=4))
def test_all_that_was_printed_is_read(events: List[Event]) -> None:
    assert list(read([f"[INFO] [1795315083.4]: {event}\n" for event in events])) == events


@pytest.mark.parametrize(
    "line",
    [
        "",
        "[INFO] [1795315083.4]: /two_mutex: executor='multi', period=1",
        "   0.500 s  executor-1-1  timer1 begins",
        "   0.500 s  executor-1-1  timer1 #1 goes on",
        "   0.5 s  executor-1-1  timer1 #1 begins",
    ],
)
def test_other_lines_are_left_out(line: str) -> None:
    assert list(read([line])) == []


def test_colours_of_a_terminal_are_left_out() -> None:
    event = Event(0.5, "executor-1-1", "commands", 2, True, "go: left")
    assert list(read([f"\x1b[0m[INFO] [12.3]: {event}\x1b[0m\r\n"])) == [event]


def test_a_line_is_readable() -> None:
    assert str(Event(0.0312, "executor-1-2", "timer1", 1, True)) == (
        "   0.031 s  executor-1-2  timer1 #1 begins"
    )
