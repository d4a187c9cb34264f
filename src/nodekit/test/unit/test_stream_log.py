"""What is logged of lines that are too long to read."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.messaging.stream_log import LONGEST, shortened


@given(st.text(max_size=LONGEST))
def test_a_line_is_logged_as_it_is(text):
    assert shortened(text) == text


@pytest.mark.parametrize("size", [LONGEST + 1, 10_000_000])
def test_a_very_long_one_keeps_its_ends_and_says_how_much_is_left_out(size):
    text = "start" + "x" * (size - 8) + "end"
    short = shortened(text)
    assert short.startswith("start") and short.endswith("end")
    assert "(%d characters)" % (size - LONGEST) in short
    assert len(short) < LONGEST + 40
