"""Tests of the rate-limited log, with a fast stream and very long lines."""

import inspect
import logging
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.messaging.rate_limited_log import LONGEST, RateLimitedLog, shortened


@given(st.text(max_size=LONGEST))
def test_a_line_is_logged_as_it_is(text):
    assert shortened(text) == text


@pytest.mark.parametrize("size", [LONGEST + 1, 10_000_000])
def test_a_very_long_one_keeps_its_ends_and_says_how_much_is_left_out(size):
    text = "start" + "x" * (size - 8) + "end"
    short = shortened(text)
    assert short.startswith("start") and short.endswith("end")
    assert f"({size - LONGEST} characters)" in short
    assert len(short) < LONGEST + 40
    logged = []
    RateLimitedLog(log=logged.append).line(text)
    assert logged == [short]


@given(st.integers(1, 20), st.lists(st.integers(0, 50), max_size=10))
def test_each_second_some_lines_are_logged_and_the_rest_is_counted(per_second, seconds):
    logged, expected = [], []
    log = RateLimitedLog(per_second, logged.append)
    limit = per_second + RateLimitedLog.JITTER
    for second, count in enumerate(seconds):
        lines = [f"{number} of second {second}" for number in range(count)]
        for line in lines:
            log.line(line)
        log.end_second(float(second))
        expected += lines[:limit]
        if count > limit:
            expected.append(f"... and {count - limit} more in the last second")
    assert logged == expected


def test_slow_stream_is_logged_line_by_line_without_delay():
    logged = []
    log = RateLimitedLog(log=logged.append)
    for number in range(100):
        log.line(str(number))
        assert logged[-1] == str(number)
        log.end_second()
    assert len(logged) == 100


def test_lines_of_several_threads_are_all_logged_or_counted():
    logged = []
    log = RateLimitedLog(per_second=10, log=logged.append)

    def talk():
        for _ in range(1000):
            log.line("line")

    threads = [threading.Thread(target=talk) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20.0)
    log.end_second()
    limit = 10 + RateLimitedLog.JITTER
    assert logged == ["line"] * limit + [f"... and {4000 - limit} more in the last second"]


def test_a_line_that_cannot_be_logged_counts_and_holds_up_no_other():
    logged = []

    def fail_first(text):
        if text == "first":
            raise OSError("the disk is full")
        logged.append(text)

    log = RateLimitedLog(log=fail_first)
    with pytest.raises(OSError):
        log.line("first")
    log.line("second")
    assert logged == ["second"]


class Author:
    """A class that logs lines."""

    def __init__(self, log):
        self.log = log

    def write(self):
        self.log.line("100 %")
        return inspect.currentframe().f_lineno - 1


def test_lines_carry_the_place_of_the_call(caplog):
    caplog.set_level(logging.INFO)
    logger = logging.getLogger("rosout")
    logger.addHandler(caplog.handler)
    before, logger.propagate = logger.propagate, False
    try:
        log = RateLimitedLog(per_second=1)
        line = [Author(log).write() for _ in range(9)][0]
        log.end_second()
    finally:
        logger.propagate = before
        logger.removeHandler(caplog.handler)
    *lines, summary = caplog.records
    assert [record.getMessage() for record in lines] == ["100 %"] * len(lines)
    assert summary.getMessage() == "... and 6 more in the last second"
    for record in caplog.records:
        place = (record.pathname, record.lineno, record.funcName, record.levelname)
        assert place == (__file__, line, "Author.write", "INFO")
