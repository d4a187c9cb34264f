"""The phase accumulator against exact rational arithmetic."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.signals.oscillator import PhaseAccumulator

BOUND = 1e-12


def arctan_of_inverse(denominator, terms):
    """Return arctan(1/denominator) by its power series, as a fraction."""
    return sum(Fraction((-1) ** k, (2 * k + 1) * denominator ** (2 * k + 1)) for k in range(terms))


# Machin's formula, to better than 40 digits.
EXACT_TWO_PI = Fraction(
    round(8 * (4 * arctan_of_inverse(5, 32) - arctan_of_inverse(239, 10)) * 10**45), 10**45
)

frequencies = st.floats(-1e4, 1e4)


def exact_phase(samples):
    """Return the phase after samples of (time, frequency), in exact arithmetic."""
    phase, before = Fraction(0), Fraction(0)
    for time, frequency in samples:
        phase += Fraction(frequency) * (Fraction(time) - before)
        before = Fraction(time)
    return phase


def phase_error(phase, exact):
    """Return the circular distance of a phase from an exact phase [rad]."""
    turns = (Fraction(phase) - exact) / EXACT_TWO_PI
    return abs(float((turns - round(turns)) * EXACT_TWO_PI))


def test_the_reference_knows_pi():
    assert float(EXACT_TWO_PI) == 2.0 * math.pi


@given(st.floats(0.0, 1e9), frequencies)
def test_constant_frequency_gives_frequency_times_time(time, frequency):
    phase = PhaseAccumulator().advance(time, frequency)
    assert phase_error(phase, exact_phase([(time, frequency)])) < BOUND


@given(st.lists(st.tuples(st.floats(0.0, 1e3), frequencies), max_size=40))
def test_any_run_of_changes_follows_the_exact_sum(steps):
    accumulator = PhaseAccumulator()
    samples, time = [], 0.0
    for interval, frequency in steps:
        time += interval
        samples.append((time, frequency))
        assert phase_error(accumulator.advance(time, frequency), exact_phase(samples)) < BOUND


@given(frequencies, frequencies, st.floats(0.0, 1e5), st.floats(0.0, 1e-3))
def test_a_change_of_frequency_makes_no_jump(before, after, time, interval):
    accumulator = PhaseAccumulator()
    first = accumulator.advance(time, before)
    second = accumulator.advance(time + interval, after)
    advance = Fraction(after) * (Fraction(time + interval) - Fraction(time))
    assert phase_error(second, Fraction(first) + advance) < 2 * BOUND


@pytest.mark.parametrize("interval", [1e-3, 0.1])
def test_a_billion_samples_end_within_the_bound(interval):
    """Half a billion samples at one frequency, a change, then as many close to Nyquist.

    The phase between two changes depends only on time, not on the number of samples, as the second
    test below shows. So the long intervals are skipped.
    """
    accumulator = PhaseAccumulator()
    half = 500_000_000 * interval
    slow, fast = 2.0 * math.pi, 3.14 / interval
    samples = [(half, slow), (2.0 * half, fast)]
    for time, frequency in samples:
        phase = accumulator.advance(time, frequency)
    assert phase_error(phase, exact_phase(samples)) < BOUND
    for n in range(1, 1000):
        samples_now = samples + [(2.0 * half + n * interval, fast)]
        phase = accumulator.advance(2.0 * half + n * interval, fast)
        assert phase_error(phase, exact_phase(samples_now)) < BOUND


def test_samples_in_between_add_no_error():
    accumulator = PhaseAccumulator()
    frequency = 31.0
    for n in range(200_001):
        phase = accumulator.advance(n / 1000.0, frequency)
    assert phase_error(phase, exact_phase([(200.0, frequency)])) < BOUND


def test_a_hundred_thousand_changes_add_no_error():
    accumulator = PhaseAccumulator()
    # Exact too, and quicker than fractions: whole numbers of 2^-60 s, and frequencies are whole.
    exact, before = 0, 0
    for n in range(1, 100_001):
        time, frequency = n * 0.01, 300 + (n % 7)
        phase = accumulator.advance(time, float(frequency))
        now = int(math.ldexp(time, 60))
        exact += frequency * (now - before)
        before = now
    assert phase_error(phase, Fraction(exact, 2**60)) < BOUND


def test_zero_frequency_holds_the_phase_and_a_negative_one_runs_it_backwards():
    accumulator = PhaseAccumulator()
    held = accumulator.advance(1.0, 2.0)
    assert accumulator.advance(50.0, 0.0) == pytest.approx(held)
    assert accumulator.advance(51.0, -2.0) == pytest.approx(held - 2.0)


def test_reset_returns_to_phase_zero_at_time_zero():
    accumulator = PhaseAccumulator()
    accumulator.advance(1000.0, 5.0)
    accumulator.reset()
    assert accumulator.advance(0.0, 5.0) == 0.0
    assert accumulator.advance(0.25, 5.0) == 1.25
