"""Spectra against scipy, and peaks against known sines."""

import math

import numpy
import pytest
import scipy.signal
from hypothesis import example, given, settings
from hypothesis import strategies as st

from topic_scope.analysis.spectrum import NOT_SINGLE, WINDOWS, Spectrum, peaks, reduced, spectrum

EPOCH = 1.7e9

windows = st.sampled_from(sorted(WINDOWS))


def decibels(amplitudes: numpy.ndarray) -> numpy.ndarray:
    return 20.0 * numpy.log10(numpy.maximum(amplitudes, 1e-300))


def signal(seed: int, times: numpy.ndarray) -> numpy.ndarray:
    """Return three sines with noise and a mean."""
    random = numpy.random.RandomState(seed)
    values = 5.0 + 0.01 * random.standard_normal(len(times))
    for frequency, peak in zip(random.uniform(2.0, 45.0, 3), random.uniform(0.01, 10.0, 3)):
        values += peak * numpy.sin(2 * math.pi * frequency * times + random.uniform(0.0, 6.0))
    return values


@given(st.integers(0, 1000), windows, st.integers(1, 9), st.integers(200, 2000))
@settings(max_examples=40)
def test_the_same_as_scipy_to_a_tenth_of_a_decibel(
    seed: int, window: str, averages: int, count: int
) -> None:
    times = numpy.arange(count) / 100.0
    values = signal(seed, times)
    found = spectrum(EPOCH + times, values, window, averages)
    assert found is not None
    length = 2 * (count // (averages + 1))
    name = "boxcar" if window == "rectangular" else window
    frequencies, power = scipy.signal.welch(
        values[: length * (averages + 1) // 2],
        100.0,
        name,
        length,
        length // 2,
        scaling="spectrum",
    )
    assert found.step == pytest.approx(frequencies[1], rel=1e-6)
    expected = numpy.sqrt(2.0 * power)
    # The lines at 0 Hz and at half of the rate are not sines.
    inner = slice(1, len(expected) - 1)
    difference = decibels(found.amplitudes[inner]) - decibels(expected[inner])
    assert numpy.abs(difference).max() < 0.1
    assert found.seconds == pytest.approx(count / 100.0)


@given(st.floats(1.0, 20.0), st.floats(1e-3, 1e3), st.integers(0, 1000))
@settings(max_examples=30)
def test_uneven_samples_are_put_at_even_times(frequency: float, peak: float, seed: int) -> None:
    random = numpy.random.RandomState(seed)
    times = numpy.sort(numpy.arange(3000) / 200.0 + random.uniform(0.0, 0.004, 3000))
    values = peak * numpy.sin(2 * math.pi * frequency * times)
    found = spectrum(EPOCH + times, values, "flattop")
    assert found is not None
    (at, height, *_), *_ = peaks(found, "flattop", 1)
    assert at == pytest.approx(frequency, abs=found.step)
    assert decibels(numpy.array(height / peak)) == pytest.approx(0.0, abs=0.1)


@settings(max_examples=40)
@given(st.floats(3.0, 40.0), st.floats(1e-3, 1e3), st.sampled_from(["hann", "blackman"]))
def test_peak_is_interpolated_between_lines(frequency: float, peak: float, window: str) -> None:
    times = numpy.arange(1000) / 100.0
    values = peak * numpy.sin(2 * math.pi * frequency * times)
    found = spectrum(EPOCH + times, values, window)
    assert found is not None
    shown_peaks = peaks(found, window)
    assert shown_peaks[0][0] == pytest.approx(frequency, abs=0.1 * found.step)
    assert decibels(numpy.array(shown_peaks[0][1] / peak)) == pytest.approx(0.0, abs=0.1)
    assert len(shown_peaks) == 1


@pytest.mark.parametrize("averages", [8, 16, 32])
def test_a_part_of_few_periods_has_no_figures(averages: int) -> None:
    times = numpy.arange(1000) / 100.0
    found = spectrum(times, 2.0 * numpy.sin(2 * math.pi * times), averages=averages)
    assert found is not None
    shown_peaks = peaks(found, "hann")
    assert shown_peaks and shown_peaks[0].uncertainty is None


@given(
    st.floats(0.2, 49.0),
    st.floats(0.0, 6.28),
    windows,
    st.sampled_from([1, 2, 4, 8, 16, 32, 64]),
    st.integers(0, 1000),
)
@settings(max_examples=100)
@example(1.0, 0.0, "hann", 4, 0)
@example(48.0, 0.0, "rectangular", 64, 0)
def test_peak_is_within_its_uncertainty_or_not_measurable(
    frequency: float, angle: float, window: str, averages: int, seed: int
) -> None:
    times = numpy.arange(1000) / 100.0
    values = 2.0 * numpy.sin(2 * math.pi * frequency * times + angle)
    values += 1e-3 * numpy.random.RandomState(seed).standard_normal(len(times))
    found = spectrum(EPOCH + times, values, window, averages)
    assert found is not None
    for at, height, uncertainty, _ in peaks(found, window, 1):
        line = frequency / found.step
        is_clear = 6.0 < line < len(found.amplitudes) - 7.0
        assert uncertainty is not None or not is_clear
        if uncertainty is not None:
            assert 0.0 < uncertainty <= 0.5 * found.step
            assert abs(at - frequency) <= uncertainty
            assert height == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("window", sorted(WINDOWS))
def test_two_sines_in_one_peak_are_not_a_single_line(window: str) -> None:
    times = numpy.arange(1000) / 100.0
    values = sum(numpy.sin(2 * math.pi * hertz * times) for hertz in (10.0, 10.15))
    found = spectrum(EPOCH + times, numpy.asarray(values), window)
    assert found is not None
    shown_peaks = peaks(found, window, 1)[0]
    assert (shown_peaks.uncertainty, shown_peaks.reason) == (None, NOT_SINGLE)


def test_a_chirp_is_not_a_single_line() -> None:
    times = numpy.arange(1000) / 100.0
    found = spectrum(EPOCH + times, numpy.sin(2 * math.pi * (36.0 * times + 0.2 * times**2)))
    assert found is not None
    shown_peaks = peaks(found, "hann")
    assert shown_peaks and {one.reason for one in shown_peaks} == {NOT_SINGLE}


def test_sines_apart_are_single_lines_each() -> None:
    times = numpy.arange(1000) / 100.0
    values = sum(numpy.sin(2 * math.pi * hertz * times) for hertz in (10.03, 13.33, 31.0))
    found = spectrum(EPOCH + times, numpy.asarray(values))
    assert found is not None
    shown_peaks = peaks(found, "hann")
    assert sorted(round(one.frequency, 2) for one in shown_peaks) == [10.03, 13.33, 31.0]
    assert not any(one.reason for one in shown_peaks)
    assert peaks(found, "hann", 2) == shown_peaks[:2]


def test_bunched_samples_do_not_raise_peaks() -> None:
    # In bunches of ten, as received on a busy machine.
    index = numpy.arange(1000)
    times = index // 10 * 0.1 + index % 10 * 1e-5
    found = spectrum(times, numpy.sin(2 * math.pi * index / 100.0))
    assert found is not None
    assert found.amplitudes.max() == pytest.approx(1.0, abs=0.05)


def test_sample_at_the_time_of_another_is_left_out() -> None:
    times = numpy.arange(200) / 100.0
    values = numpy.sin(2 * math.pi * 5.0 * times)
    one = spectrum(times, values)
    other = spectrum(numpy.insert(times, 50, times[49]), numpy.insert(values, 50, values[49]))
    assert one is not None and other is not None
    assert other.amplitudes == pytest.approx(one.amplitudes)


def test_spectrum_does_not_cross_a_gap() -> None:
    times = numpy.concatenate([numpy.arange(300) / 100.0, 10.0 + numpy.arange(500) / 100.0])
    values = numpy.where(times < 5.0, 100.0, 1.0) * numpy.sin(2 * math.pi * 10.0 * times)
    found = spectrum(times, values, longest=0.05)
    assert found is not None and found.seconds == pytest.approx(5.0)
    assert found.amplitudes.max() == pytest.approx(1.0, rel=1e-3)


@settings(max_examples=30)
@given(st.lists(st.floats(), max_size=40), windows, st.integers(1, 5))
def test_anything_has_a_spectrum_or_none(values: list, window: str, averages: int) -> None:
    with numpy.errstate(all="ignore"):
        found = spectrum(
            numpy.arange(float(len(values))), numpy.array(values, float), window, averages
        )
        if found is not None:
            assert len(peaks(found, window)) <= 5


def test_no_peak_is_lost_on_a_screen_of_few_points() -> None:
    lines = numpy.zeros(1001)
    lines[777] = 1.0
    first, step, values = reduced(Spectrum(0.5, lines, 1.0), 100)
    assert len(values) <= 100
    assert first + int(values.argmax()) * step == pytest.approx(777 * 0.5, abs=step / 2)
