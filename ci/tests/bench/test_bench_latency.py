"""Tests of the figures of ci/bench for a turn of nodes that were stopped before."""

import pytest

from ci.benchmark import latency, loop
from ci.benchmark.record import Sample
from ci.benchmark.stacks import Run

PERIOD, HOP = 0.01, 0.001


def samples(first, count, delay=0.0):
    return [Sample(first + PERIOD * number + delay, float(number)) for number in range(count)]


def test_only_samples_of_the_turn_count_and_pauses_lose_none():
    sent = samples(10.0, 50) + samples(30.0, 100)
    received = samples(10.0, 50, HOP) + samples(30.0, 100, 2.0 * HOP)
    run = Run(sent, received, 5.0, 30.255, 30.905)
    found = latency.figures(latency.answered(run, 29.9), run)
    assert found["p50_us"] == pytest.approx(2000.0)
    assert found["samples"] == 65 and found["lost"] == 0 and found["cpu_percent"] == 5.0


def test_sample_recorded_but_not_sent_before_the_pause_shifts_nothing():
    noted_before = samples(10.0, 50)
    sent = noted_before + samples(30.0, 100)
    received = [Sample(29.95, 0.0)] + samples(30.0, 100, HOP)
    run = Run(sent, received, 5.0, 30.255, 30.905)
    found = latency.figures(latency.answered(run, 29.9), run)
    assert found["p50_us"] == pytest.approx(1000.0) and found["lost"] == 0


def test_answers_lost_in_a_turn_are_counted():
    received = samples(30.0, 100, HOP)
    del received[50:53]
    run = Run(samples(30.0, 100), received, 5.0, 30.255, 30.905)
    assert latency.figures(latency.answered(run, 29.9), run)["lost"] == 3


def test_inputs_of_the_loop_identify_their_output():
    sent = [Sample(30.0 + PERIOD * number, float(number)) for number in range(100)]
    received = [Sample(one.moment + HOP, one.value) for one in sent if one.value != 60.0]
    received.insert(0, Sample(29.0, -1.0))  # stops the motor, and answers nothing
    run = Run(sent, received, 5.0, 30.255, 30.905)
    found = latency.figures(loop.answered(run), run)
    assert found["p50_us"] == pytest.approx(1000.0) and found["lost"] == 1
