"""Values of a coursework's metrics, such as its frequency error, computed from its records."""

import math
from typing import Dict, Optional, Sequence, Tuple

from pid_control.signal_judging.evidence import (
    DISTORTED,
    GENERATOR,
    PROCESS,
    CourseworkEvidence,
    TrialFeatures,
)
from pid_control.signal_judging.features import ProcessFeatures
from pid_control.signal_judging.parameter_roles import GENERATOR_ROLES, role_of, values_in_rad

#: Figures by scenario and metric; None if not measurable.
Figures = Dict[Tuple[str, str], Optional[float]]
#: Fewest periods by which a sine is known.
_FEWEST_PERIODS = 1.2


def figures_of(evidence: CourseworkEvidence) -> Figures:
    """Return all figures that can be measured; the others are missing."""
    found: Figures = {("launch", "missing_nodes"): 2.0 if evidence.missing else 0.0}
    if evidence.baseline is not None:
        found.update({("signal", name): one for name, one in _of_signal(evidence).items()})
        found.update({("process", name): one for name, one in _of_process(evidence).items()})
    restart = evidence.restart
    if restart is not None and evidence.baseline is not None:
        found["restart", "free_running"] = float(restart.oscillates)
        before = evidence.baseline.features.process
        is_known_change = before is not None and not restart.oscillates
        found["restart", "change"] = _change(before, restart.after) if is_known_change else None
    parameters = evidence.parameters
    if parameters is not None:
        found["parameters", "of_generator"] = float(parameters.read_by(GENERATOR))
        found["parameters", "of_process"] = float(parameters.read_by(PROCESS))
        found["parameters", "unread"] = float(len(parameters.unread()))
        unused = float(len(parameters.unused_files))
        found["yaml", "unused"] = unused if parameters.has_files else None
    if evidence.outside is not None:
        found["namespace", "outside"] = float(len(evidence.outside))
    return found


def is_known(features: TrialFeatures) -> bool:
    """Return True if the signal is a sine that was recorded for long enough."""
    sine = features.signal.sine
    return sine is not None and sine.periods >= _FEWEST_PERIODS


def _of_signal(evidence: CourseworkEvidence) -> Dict[str, Optional[float]]:
    assert evidence.baseline is not None
    baseline = evidence.baseline
    signal, values = baseline.features.signal, baseline.signal.values
    found: Dict[str, Optional[float]] = {
        "rate": signal.rate or 0.0,
        "not_finite": float(len(values) - len(baseline.signal.finite().values)),
    }
    sine = signal.sine
    if sine is None or not is_known(baseline.features):
        found["distortion"] = 1.0 if sine is None else None
        return found
    found["distortion"] = sine.distortion
    if sine.distortion > DISTORTED:
        return found
    found["amplitude"], found["frequency"] = sine.amplitude, sine.frequency
    errors = []
    for name, value in baseline.constants.items():
        role = role_of(name, GENERATOR_ROLES)
        if role == "amplitude":
            errors.append(_relative(sine.amplitude, value))
        elif role == "frequency":
            errors.append(frequency_error(sine.frequency, value, name))
    found["field_error"] = max(errors) if errors else None
    if evidence.parameters is not None:
        amplitude = evidence.parameters.value_of(GENERATOR, "amplitude")
        if amplitude is not None:
            found["amplitude_error"] = _relative(sine.amplitude, amplitude[1])
        frequency = evidence.parameters.value_of(GENERATOR, "frequency")
        if frequency is not None:
            found["frequency_error"] = frequency_error(sine.frequency, frequency[1], frequency[0])
    return found


def _of_process(evidence: CourseworkEvidence) -> Dict[str, Optional[float]]:
    assert evidence.baseline is not None
    baseline = evidence.baseline
    output, process = baseline.output, baseline.features.process
    found: Dict[str, Optional[float]] = {
        "rate": output.rate() or 0.0,
        "not_finite": float(len(output.values) - len(output.finite().values)),
    }
    sine = baseline.features.signal.sine
    if sine is None or sine.distortion > DISTORTED or not is_known(baseline.features):
        return found  # the input of the shift is unknown
    if process is None:
        found["distortion"] = 1.0
        return found
    found["distortion"] = process.distortion
    if process.distortion > 2.0 * DISTORTED:
        return found
    found["gain"], found["offset"] = process.gain, process.offset
    found["gain_change"] = abs(process.gain - 1.0)
    found["phase_shift"] = process.shifts[0]
    found["shift"] = process.shift_error(0.0)
    found["below_zero"] = max(0.0, -process.lowest / (process.gain * sine.amplitude))
    if evidence.parameters is not None:
        gain = evidence.parameters.value_of(PROCESS, "gain")
        if gain is not None:
            measured = (process.gain, process.gain * sine.amplitude)
            found["gain_error"] = min(_relative(one, abs(gain[1])) for one in measured)
        shift = evidence.parameters.value_of(PROCESS, "phase_shift")
        if shift is not None:
            found["shift_error"] = _shift_error(
                process,
                values_in_rad(shift[0], shift[1], math.radians(1.0), "deg"),
                sine.frequency,
                signal_rate=(baseline.features.signal.rate or math.inf),
            )
    return found


def _shift_error(
    process: ProcessFeatures, angles: Sequence[float], frequency: float, signal_rate: float
) -> float:
    """Return the distance from a phase, a lead or a lag [rad].

    A node may hold a sample for one iteration before it answers: that difference is ignored.
    """
    errors = [process.shift_error(sign * one) for one in angles for sign in (1.0, -1.0)]
    return max(0.0, min(errors) - frequency / signal_rate)


def frequency_error(frequency: float, value: float, name: str = "") -> float:
    """Return the relative difference from a frequency in rad/s or in Hz.

    :param frequency: measured [rad/s]
    :param value: the other frequency
    :param name: its name, which may state its unit
    """
    return min(_relative(frequency, one) for one in frequencies_of(name, abs(value)))


def frequencies_of(name: str, value: float) -> Sequence[float]:
    """Return the frequencies that a parameter may mean [rad/s].

    :param name: its name, which may state its unit
    :param value: its value, in rad/s or in Hz
    """
    return values_in_rad(name, value, 2.0 * math.pi, "hz")


def _relative(measured: float, wanted: float) -> float:
    return abs(measured - wanted) / max(abs(measured), abs(wanted))


def _change(before: Optional[ProcessFeatures], after: Optional[ProcessFeatures]) -> float:
    """Return the largest change of gain, phase [rad] and offset."""
    if before is None or after is None:
        return 1.0
    size = max(abs(before.offset), before.gain)
    return max(
        _relative(after.gain, before.gain),
        after.shift_distance(before),
        abs(after.offset - before.offset) / size,
    )
