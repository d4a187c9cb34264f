"""The estimate of a phase by itself, without amplitude, time and frequency."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from basic_comms.conditioning.phase_estimate import LEAST_TOLERANCE, PhaseEstimate

TOLERANCE = LEAST_TOLERANCE + 1e-7
phases = st.floats(-math.pi, math.pi)


def feed(estimate, phase, angle, slack=1e-9, other=None):
    """Take in an exact sample; return the cosine and, if that was searched for, which angle."""
    value = math.sin(phase)
    cosine = estimate.follow(angle, slack, value, TOLERANCE)
    return estimate.search(value, TOLERANCE, angle, other) if cosine is None else (cosine, None)


def two_samples(phase, angle=1.0):
    """Return an estimate that has seen a sine at a phase, and an angle before."""
    estimate = PhaseEstimate()
    feed(estimate, phase - angle, 0.0)
    feed(estimate, phase, angle)
    return estimate


@given(phases)
def test_first_sample_allows_rising_and_falling_phase(phase):
    estimate = PhaseEstimate()
    feed(estimate, phase, 0.0)
    feed(estimate, phase + 1.0, 1.0)
    cosine, _ = feed(estimate, phase + 2.0, 1.0)
    assert cosine == pytest.approx(math.cos(phase + 2.0), abs=1e-5)


@given(phases.filter(lambda phase: abs(math.cos(phase)) > 0.1))
def test_two_samples_make_the_usual_case(phase):
    estimate = two_samples(phase)
    cosine, searched = feed(estimate, phase + 0.3, 0.3)
    assert cosine == pytest.approx(math.cos(phase + 0.3), abs=1e-6)
    assert searched is None


def test_sample_narrows_interval_widened_by_slack():
    estimate = two_samples(0.2)
    for number in range(1, 200):
        # Each step alone may be wrong by as much; together they are not narrow any more.
        cosine, searched = feed(estimate, 0.2 + 0.01 * number + 3e-7 * number, 0.01, 3e-6)
        assert cosine == pytest.approx(math.cos(0.2 + (0.01 + 3e-7) * number), abs=1e-4)
        assert searched is None


def test_slack_without_samples_ends_the_usual_case():
    estimate = two_samples(0.2)
    estimate.advance(0.1, 1e-3)
    assert estimate.phase == pytest.approx(0.3, abs=1e-6)
    cosine, searched = feed(estimate, 0.4005, 0.1)
    assert searched is False
    assert cosine == pytest.approx(math.cos(0.4005), abs=1e-6)
    assert feed(estimate, 0.5005, 0.1)[1] is None, "narrow again"


@pytest.mark.parametrize("further", [0.05, -0.05])
def test_contradicted_angle_selects_the_other(further):
    estimate = two_samples(0.2)
    cosine, other_was_right = feed(estimate, 0.3 + further, 0.1, other=(further, 1e-6))
    assert other_was_right is True
    assert cosine == pytest.approx(math.cos(0.3 + further), abs=1e-6)
    assert estimate.phase == pytest.approx(0.3 + further, abs=1e-6)


def test_phase_nearest_to_other_angle_is_preferred():
    estimate = PhaseEstimate()
    estimate.start(0.2)
    feed(estimate, 0.2, 0.0)
    _, other_was_right = feed(estimate, 0.2, 2.5, other=(-2.5, 1e-6))
    assert other_was_right is True
    assert estimate.phase == pytest.approx(0.2, abs=1e-6)


def test_neither_angle_need_be_right():
    estimate = two_samples(0.2)
    cosine, other_was_right = feed(estimate, 0.53, 0.1, other=(0.05, 1e-6))
    assert other_was_right is False
    assert cosine == pytest.approx(math.cos(0.3), abs=1e-6), "an outlier leaves it on its course"
    cosine, _ = feed(estimate, 0.4, 0.1)
    assert cosine == pytest.approx(math.cos(0.4), abs=1e-6)


@given(phases)
@example(1.5710067749023438)
def test_start_forgets_all_but_a_guess(phase):
    estimate = two_samples(phase + 2.0)
    estimate.start(phase + 1000.0 * math.tau)
    cosine, searched = feed(estimate, phase, 0.0, 0.0)
    assert searched is False
    # Near a crest, one sample only shows that it is a crest: 1 - sin x = x^2 / 2.
    assert cosine == pytest.approx(math.cos(phase), abs=math.sqrt(2.0 * TOLERANCE))


def test_too_large_phase_is_not_used_as_guess():
    estimate = PhaseEstimate()
    for phase in (1e15, 1e300, math.inf):
        estimate.start(1.0)
        estimate.start(phase)
        assert estimate.phase == 0.0
