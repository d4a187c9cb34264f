"""Tests of the figures that ci/bench computes from recorded times."""

import random
import statistics

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ci.benchmark import analysis


def grid(count, rate, start=100.0):
    return [start + number / rate for number in range(count)]


@settings(max_examples=40)
@given(
    delays=st.lists(st.floats(1e-6, 0.02), min_size=3, max_size=60),
    missing=st.integers(0, 20),
)
def test_match_without_the_first_answers_shifts_nothing(delays, missing):
    rate = 1000.0
    delays[0] = min(delays[0], 0.9 / rate)  # one arrives within a period
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


def test_match_after_a_backlog_shifts_nothing():
    sent = grid(50, 1000.0)
    # The receiver is stopped until the 10th sample, then catches up.
    received = [max(sample, sent[10]) + 1e-4 + 1e-6 * n for n, sample in enumerate(sent)]
    matched = analysis.match_in_order(sent, received)
    assert matched.latencies[0] == pytest.approx(0.0101, abs=1e-6)


def test_match_counts_lost_answers():
    sent = grid(100, 1000.0)
    received = [moment + 1e-4 for moment in sent]
    del received[40:43]
    del received[60]
    matched = analysis.match_in_order(sent, received)
    assert matched.lost == 4
    assert matched.latencies == pytest.approx([1e-4] * 96)
    assert analysis.match_in_order([1.0, 2.0], []).lost == 2


def test_match_ignores_losses_after_the_end():
    sent = grid(100, 1000.0)
    received = [moment + 1e-4 for moment in sent[:90]]
    assert analysis.match_in_order(sent, received, until=sent[94]).lost == 5
    assert analysis.match_in_order(sent, received, until=sent[89]).lost == 0


def test_match_refuses_more_answers_than_samples():
    with pytest.raises(ValueError):
        analysis.match_in_order([1.0], [0.5, 1.5])


@settings(max_examples=30)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=12))
def test_interval_holds_the_median_and_is_reproducible(values):
    found = analysis.estimate(values)
    assert min(values) <= found.low <= found.median <= found.high <= max(values)
    assert found.median == pytest.approx(statistics.median(values))
    assert analysis.estimate(values) == found


def test_interval_has_its_confidence():
    draw = random.Random(2)
    hits = 0
    for _ in range(200):
        found = analysis.estimate([draw.gauss(1.0, 0.1) for _ in range(11)])
        hits += found.low <= 1.0 <= found.high
    assert 0.90 * 200 <= hits


@pytest.mark.parametrize("turns", [1, 2, 3, 6, 45])
def test_confidence_of_few_turns_is_less(turns):
    assert analysis.confidence(turns) == (0.95 if turns >= 6 else 1.0 - 2.0 * 0.5**turns)
