"""Measurements of two hundred known signals: right within their uncertainty, or with a reason."""

import math
from functools import lru_cache
from typing import Dict, List

import numpy
import pytest
from known_signals import COUNTS, EPOCH, Signal, signals

from topic_scope.analysis.measurement import Measurement, measured
from topic_scope.analysis.waveform import measure_waveform, phase
from topic_scope.analysis.spectrum import peaks, spectrum
from topic_scope.analysis.statistics import measure

SIGNALS = signals()
#: Kinds of sines.
SINES = ("sine", "gap", "late")
#: Least number of figures of each kind that must be measurable.
MEASURED = {"sine": 0.8, "square": 0.9, "step": 0.5, "gap": 0.8, "late": 0.8}

of_each_kind = pytest.mark.parametrize("kind", COUNTS)


def of_kind(kind: str) -> List[Signal]:
    """Return the signals of a kind."""
    return [signal for signal in SIGNALS if signal.kind == kind]


@lru_cache(maxsize=None)
def measured_of(kind: str) -> "List[Dict[str, Measurement]]":
    """Return the measurements of the signals of a kind."""
    return [measures(signal) for signal in of_kind(kind)]


def measures(signal: Signal) -> Dict[str, Measurement]:
    """Return all measurements of a signal that may fail."""
    samples = signal.times, signal.values
    found = measure_waveform(*samples, signal.longest)
    if signal.kind in SINES:
        turns = 2.0 * math.pi * signal.truth["frequency"] * (signal.times - EPOCH)
        reference = signal.times, numpy.sin(turns)
        found["phase"] = phase(samples, reference, signal.longest)
    return found


def is_true(name: str, figure: Measurement, signal: Signal) -> bool:
    """Return whether a figure is right within its uncertainty, or has a reason instead."""
    if figure.value is None:
        return bool(figure.reason)
    if name not in signal.truth:
        return False
    error = figure.value - signal.truth[name]
    if name == "phase":
        error = (error + 180.0) % 360.0 - 180.0
    return abs(error) <= figure.uncertainty + 1e-9 * abs(figure.value)


def test_there_are_two_hundred() -> None:
    assert len(SIGNALS) == 200
    assert {kind: len(of_kind(kind)) for kind in COUNTS} == COUNTS
    hertz = [signal.truth["frequency"] for signal in SIGNALS if "frequency" in signal.truth]
    assert min(hertz) < 1.1 and max(hertz) > 900.0


@of_each_kind
def test_each_figure_is_true_within_its_uncertainty_or_says_why_not(kind: str) -> None:
    wrong, known, there = [], 0, 0
    for signal, found in zip(of_kind(kind), measured_of(kind)):
        for name, figure in found.items():
            if not is_true(name, figure, signal):
                wrong.append((name, signal.truth.get(name), figure))
            known += name in signal.truth
            there += figure.value is not None
    assert not wrong
    if kind in MEASURED:
        assert there >= MEASURED[kind] * known > 0
    else:
        assert known == 0


@pytest.mark.parametrize(
    "name, unit, most",
    [("frequency", 0.0, 0.01), ("phase", 360.0, 1e-3), ("rise", 0.0, 0.5), ("duty", 100.0, 0.05)],
)
def test_uncertainty_of_a_sine_is_small(name: str, unit: float, most: float) -> None:
    """The uncertainty is small, relative to the figure or to the whole."""
    found = zip(measured_of("sine"), of_kind("sine"))
    parts = [
        figures[name].uncertainty / (unit or signal.truth[name])
        for figures, signal in found
        if figures[name].value is not None
    ]
    assert len(parts) > 30
    assert numpy.median(parts) < most


@pytest.mark.parametrize("kind", SINES)
def test_the_highest_peak_of_the_spectrum_is_the_sine(kind: str) -> None:
    sure = 0
    for signal in of_kind(kind):
        found = spectrum(signal.times, signal.values, longest=signal.longest)
        for peak in peaks(found, "hann", 1) if found is not None else []:
            if peak.uncertainty is not None:
                sure += 1
                frequency = measured(peak.frequency, peak.uncertainty)
                assert is_true("frequency", frequency, signal)
                # A tenth of a decibel, plus the noise.
                allowed = 0.012 + 5.0 * signal.sigma / math.sqrt(len(signal.times))
                assert peak.amplitude == pytest.approx(signal.truth["amplitude"], rel=allowed)
    assert sure > 5


@of_each_kind
def test_sample_statistics_are_exact(kind: str) -> None:
    signals = of_kind(kind)
    assert signals
    for signal in signals:
        found, values = measure(signal.times, signal.values), signal.values.tolist()
        count, height = len(values), max(map(abs, values))
        mean = math.fsum(values) / count
        exact = {
            "rate": (count - 1) / (signal.times[-1] - signal.times[0]),
            "value": values[-1],
            "min": min(values),
            "max": max(values),
            "vpp": max(values) - min(values),
            "mean": mean,
            "rms": math.sqrt(math.fsum(value**2 for value in values) / count),
            "deviation": math.sqrt(math.fsum((value - mean) ** 2 for value in values) / count),
            "nan": 0.0,
        }
        assert found == {key: pytest.approx(exact[key], abs=1e-12 * height) for key in exact}
