"""Tests of the figures that ci/bench makes of recorded moments."""

import math
import random
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.benchmark import analysis
from ci.benchmark.analysis import Sample


def grid(count, rate, start=100.0):
    return [start + number / rate for number in range(count)]


@pytest.mark.parametrize(
    "share, expected", [(0.0, 1.0), (0.5, 3.0), (0.75, 4.0), (0.99, 5.0), (1.0, 5.0)]
)
def test_percentile_is_one_of_the_values(share, expected):
    assert analysis.percentile([5.0, 1.0, 4.0, 2.0, 3.0], share) == expected


def test_percentile_of_nothing_is_refused():
    with pytest.raises(ValueError):
        analysis.percentile([], 0.5)


@given(
    delays=st.lists(st.floats(1e-6, 0.02), min_size=3, max_size=60),
    missing=st.integers(0, 20),
)
def test_answers_in_order_are_matched_where_the_first_are_missing(delays, missing):
    rate = 1000.0
    delays[0] = min(delays[0], 0.9 / rate)  # one comes within a period
    sent = grid(missing + len(delays), rate)
    received, latest = [], 0.0
    for sample, delay in zip(sent[missing:], delays):
        latest = max(latest + 1e-7, sample + delay)
        received.append(latest)
    matched = analysis.match_in_order(sent, received)
    assert matched.sent == sent[missing:]
    assert matched.lost == 0
    for latency, answer, sample in zip(matched.latencies, received, sent[missing:]):
        assert latency == answer - sample


def test_backlog_at_the_first_answer_does_not_shift_the_match():
    sent = grid(50, 1000.0)
    # The receiver stands still until the 10th sample, then catches up.
    received = [max(sample, sent[10]) + 1e-4 + 1e-6 * n for n, sample in enumerate(sent)]
    matched = analysis.match_in_order(sent, received)
    assert matched.latencies[0] == pytest.approx(0.0101, abs=1e-6)


def test_lost_answers_are_counted_and_shift_nothing():
    sent = grid(100, 1000.0)
    received = [moment + 1e-4 for moment in sent]
    del received[40:43]
    del received[60]
    matched = analysis.match_in_order(sent, received)
    assert matched.lost == 4
    assert matched.latencies == pytest.approx([1e-4] * 96)


def test_what_is_sent_when_the_nodes_end_may_be_lost():
    sent = grid(100, 1000.0)
    received = [moment + 1e-4 for moment in sent[:90]]
    assert analysis.match_in_order(sent, received, until=sent[94]).lost == 5
    assert analysis.match_in_order(sent, received, until=sent[89]).lost == 0


def test_no_answer_at_all_is_all_lost():
    assert analysis.match_in_order([1.0, 2.0], []).lost == 2


def test_more_answers_than_samples_are_refused():
    with pytest.raises(ValueError):
        analysis.match_in_order([1.0], [0.5, 1.5])


def test_a_poller_shows_a_sample_when_it_first_answers_with_it_or_a_later_one():
    sent = [Sample(0.0, 1.0), Sample(0.1, 2.0), Sample(0.2, 3.0), Sample(0.3, 4.0)]
    received = [
        Sample(-0.05, 9.0),  # left from before
        Sample(0.05, 1.0 + 1e-7),
        Sample(0.06, 1.0),
        Sample(0.25, 3.0 - 1e-7),
    ]
    matched = analysis.match_first_shown(sent, received)
    assert matched.latencies == pytest.approx([0.05, 0.15, 0.05])
    assert matched.lost == 1


def test_samples_that_do_not_rise_cannot_be_told_apart():
    with pytest.raises(ValueError):
        analysis.match_first_shown([Sample(0.0, 1.0), Sample(0.1, 1.0)], [])


@given(
    slope=st.floats(-1e-4, 1e-4),
    late=st.lists(st.floats(0.0, 1e-4), min_size=1, max_size=20),
)
def test_drift_is_that_of_the_clock_and_not_the_scatter(slope, late):
    calls = [
        Sample(100.0 + due * (1.0 + slope) + late[number % len(late)], due)
        for number, due in enumerate(grid(2000, 1000.0, start=0.0))
    ]
    # Between the middles of the first and the last tenth lie nine tenths of the two seconds.
    assert analysis.drift(calls) == pytest.approx(0.9 * slope * 2.0, abs=1.001e-4)


def test_late_calls_are_no_drift():
    calls = [
        Sample(due + (5.0 if number % 111 == 0 else 0.0), due)
        for number, due in enumerate(grid(1000, 1000.0, start=0.0))
    ]
    assert analysis.drift(calls) == pytest.approx(0.0, abs=1e-9)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=12))
def test_the_interval_holds_the_median_and_is_the_same_again(values):
    low, high = analysis.interval(values)
    assert min(values) <= low <= statistics.median(values) <= high <= max(values)
    assert analysis.interval(values) == (low, high)


def test_the_interval_narrows_with_the_turns():
    draw = random.Random(1)
    turns = [draw.gauss(1.0, 0.1) for _ in range(100)]
    widths = [analysis.interval(turns[:count]) for count in (5, 20, 100)]
    assert sorted(widths, key=lambda one: one.high - one.low) == widths[::-1]


def test_the_interval_is_as_sure_as_it_says():
    draw = random.Random(2)
    hits = 0
    for _ in range(200):
        low, high = analysis.interval([draw.gauss(1.0, 0.1) for _ in range(11)])
        hits += low <= 1.0 <= high
    assert 0.90 * 200 <= hits


@pytest.mark.parametrize("turns", [1, 2, 3, 6, 45])
def test_few_turns_are_told_to_be_less_sure(turns):
    draw = random.Random(3)
    hits = 0
    for _ in range(2000):
        values = [draw.gauss(1.0, 0.1) for _ in range(turns)]
        hits += min(values) <= 1.0 <= max(values)
    assert analysis.confidence(turns) <= hits / 2000 + 0.03
    assert analysis.confidence(turns) == (0.95 if turns >= 6 else 1.0 - 2.0 * 0.5**turns)


@given(
    steps=st.lists(st.integers(1, 1000), unique=True, max_size=30).map(sorted),
    limit=st.integers(0, 1001),
)
def test_the_highest_passing_step_is_found_with_few_tries(steps, limit):
    tries = []

    def passes(step):
        tries.append(step)
        return step <= limit

    found = analysis.highest_passing(steps, passes)
    assert found == max((step for step in steps if step <= limit), default=None)
    assert len(tries) <= math.ceil(math.log2(len(steps) + 1))
