"""Chirp compared with scipy and with the integral of its frequency."""

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, signal

from basic_comms.signals.oscillator import PhaseAccumulator
from basic_comms.signals.sweeps import Chirp
from basic_comms.signals.waveforms import TWO_PI, sine

times = st.floats(0.0, 100.0)
frequencies = st.floats(0.01, 100.0)
chirps = st.builds(
    Chirp,
    frequencies,
    frequencies.map(lambda frequency: 250.0 - frequency),
    st.floats(0.1, 30.0),
    st.booleans(),
    st.booleans(),
)


@pytest.mark.parametrize("logarithmic", [False, True])
@pytest.mark.parametrize("first, last", [(1.0, 200.0), (150.0, 0.5)])
def test_samples_at_irregular_times_equal_scipy(first, last, logarithmic):
    duration = 10.0
    chirp = Chirp(first, last, duration, logarithmic, False)
    sample_times = numpy.sort(numpy.random.default_rng(1).uniform(0.0, duration, 5000))
    oscillator, before, samples = PhaseAccumulator(), 0.0, []
    for time in sample_times.tolist():
        samples.append(sine(oscillator.advance(time, chirp.mean_frequency(before, time))))
        before = time
    expected = signal.chirp(
        sample_times,
        first / TWO_PI,
        duration,
        last / TWO_PI,
        method="logarithmic" if logarithmic else "linear",
        phi=-90.0,
    )
    assert samples == pytest.approx(expected, abs=1e-10)


@given(chirps)
def test_single_sweep_stays_at_last_frequency(chirp):
    chirp = chirp._replace(repeat=False)
    just_before_end = chirp.duration * (1.0 - 1e-12)
    assert chirp.frequency(0.0) == pytest.approx(chirp.first, rel=1e-12)
    assert chirp.frequency(just_before_end) == pytest.approx(chirp.last, rel=1e-9)
    assert chirp.frequency(chirp.duration) == chirp.last
    assert chirp.frequency(1e6) == chirp.last
    assert chirp.mean_frequency(chirp.duration, 1e6) == pytest.approx(chirp.last)


@given(chirps, st.integers(0, 5), st.floats(0.01, 0.99))
def test_a_repeated_sweep_is_periodic_and_reaches_its_last_frequency(chirp, sweep, part):
    chirp = chirp._replace(repeat=True)
    elapsed = part * chirp.duration
    assert chirp.frequency(sweep * chirp.duration + elapsed) == pytest.approx(
        chirp._replace(repeat=False).frequency(elapsed), rel=1e-9
    )
    assert chirp.frequency(chirp.duration * (1.0 - 1e-12)) == pytest.approx(chirp.last, rel=1e-9)


@given(chirps, times, times)
def test_the_mean_frequency_is_the_integral_of_the_frequency(chirp, one, other):
    since, until = sorted((one, other))
    edges = [chirp.duration * sweep for sweep in range(1, int(until / chirp.duration) + 1)]
    bounds = [since] + [edge for edge in edges if since < edge < until] + [until]
    # Piece by piece, since the frequency leaps or bends at the end of a sweep.
    integral = sum(
        integrate.fixed_quad(numpy.vectorize(chirp.frequency), start, end, n=20)[0]
        for start, end in zip(bounds, bounds[1:])
    )
    mean = chirp.mean_frequency(since, until)
    assert mean * (until - since) == pytest.approx(integral, rel=1e-7, abs=1e-7)
    assert mean == pytest.approx(chirp.mean_frequency(until, since))


@given(chirps, times)
def test_mean_over_empty_interval_is_frequency(chirp, time):
    assert chirp.mean_frequency(time, time) == chirp.frequency(time)


def test_a_linear_sweep_may_pass_through_zero():
    chirp = Chirp(-4.0, 4.0, 2.0, False, False)
    assert [chirp.frequency(time) for time in (0.0, 0.5, 1.0, 2.0)] == [-4.0, -2.0, 0.0, 4.0]
    assert chirp.mean_frequency(0.0, 2.0) == 0.0
