"""Effects of a changed parameter: the nodes whose signals differ, and whether as predicted."""

import math
from typing import Dict, Optional, Set, Tuple

from pid_control.signal_judging.evidence import GENERATOR, PROCESS, TrialFeatures
from pid_control.signal_judging.features import ProcessFeatures, SignalFeatures
from pid_control.signal_judging.parameter_roles import Number
from pid_control.signal_judging.sine_fit import wrapped

#: Least relative change of a rate, an amplitude or gain, and a frequency; of a phase [rad]; of an
#: offset, as a share of the amplitude; of the distortion.
_RATE, _SIZE, _FREQUENCY, _PHASE, _OFFSET, _DISTORTION = 0.05, 0.02, 0.01, 0.06, 0.02, 0.1


def changed_nodes(before: TrialFeatures, after: TrialFeatures) -> Set[str]:
    """Return the nodes whose features have changed.

    :param before: features of a trial
    :param after: features of another trial
    """
    found = set()
    if _has_signal_changed(before.signal, after.signal):
        found.add(GENERATOR)
    if _has_process_changed(before.process, after.process):
        found.add(PROCESS)
    return found


def _has_signal_changed(before: SignalFeatures, after: SignalFeatures) -> bool:
    one, other = before.sine, after.sine
    if one is None or other is None or _differ(before.rate, after.rate, _RATE):
        return (one is None) != (other is None) or _differ(before.rate, after.rate, _RATE)
    return (
        _differ(one.amplitude, other.amplitude, _SIZE)
        or _differ(one.frequency, other.frequency, _FREQUENCY)
        or abs(one.offset - other.offset) > _OFFSET * one.amplitude
        or abs(one.distortion - other.distortion) > _DISTORTION
    )


def _has_process_changed(
    before: Optional[ProcessFeatures], after: Optional[ProcessFeatures]
) -> bool:
    if before is None or after is None:
        return (before is None) != (after is None)
    return (
        _differ(before.rate, after.rate, _RATE)
        or before.shape != after.shape
        or _differ(before.gain, after.gain, _SIZE)
        or after.shift_distance(before) > _PHASE
        or abs(before.offset - after.offset) > _OFFSET * max(abs(before.offset), before.gain)
        or abs(before.distortion - after.distortion) > _DISTORTION
        or (before.not_finite == 0) != (after.not_finite == 0)
    )


def _differ(one: Optional[float], other: Optional[float], least: float) -> bool:
    if one is None or other is None:
        return (one is None) != (other is None)
    return abs(one - other) > least * max(abs(one), abs(other))


def is_as_predicted(
    role: str, node: str, values: Tuple[Number, Number], before: TrialFeatures, after: TrialFeatures
) -> bool:
    """Return True if one feature has changed as expected from the parameter's role.

    :param role: role of the parameter
    :param node: GENERATOR or PROCESS
    :param values: its value in either trial
    :param before: features of the first trial
    :param after: features of the second trial
    """
    old, new = map(float, values)
    if node == GENERATOR:
        return _is_signal_as_predicted(role, old, new, before.signal, after.signal)
    if before.process is None or after.process is None:
        return False
    return _is_process_as_predicted(role, old, new, before.process, after.process)


def _is_signal_as_predicted(
    role: str, old: float, new: float, before: SignalFeatures, after: SignalFeatures
) -> bool:
    if role == "rate":
        return _follows(before.rate, after.rate, old, new, _RATE)
    one, other = before.sine, after.sine
    if one is None or other is None:
        return False
    sizes: Dict[str, Tuple[float, float]] = {
        "amplitude": (one.amplitude, other.amplitude),
        "frequency": (one.frequency, other.frequency),
    }
    if role in sizes:
        return _follows(*sizes[role], old, new, _SIZE)
    if role == "offset":
        return abs(other.offset - one.offset - (new - old)) < _OFFSET * one.amplitude
    return False  # its phase depends on when it starts


def _is_process_as_predicted(
    role: str, old: float, new: float, before: ProcessFeatures, after: ProcessFeatures
) -> bool:
    if role == "rate":
        return _follows(before.rate, after.rate, old, new, _RATE)
    if role == "gain":
        return _follows(before.gain, after.gain, old, new, _SIZE)
    if role == "phase_shift":
        moves = [sign * move for move in (new - old, math.radians(new - old)) for sign in (1, -1)]
        return any(
            after.shift_distance(before, move) < _PHASE
            for move in moves
            if abs(wrapped(move)) > 2.0 * _PHASE
        )
    if role == "offset":
        most = _OFFSET * max(abs(after.offset), after.gain)
        pairs = ((before, old), (after, new))
        is_added = all(abs(one.offset - value) < most for one, value in pairs)
        is_scaled = all(abs(one.offset - value * one.gain) < most for one, value in pairs)
        return is_added or is_scaled
    return False


def _follows(
    before: Optional[float], after: Optional[float], old: float, new: float, most: float
) -> bool:
    """Return True if a feature has changed in proportion to a value."""
    if before is None or after is None or old == 0.0 or before == 0.0:
        return False
    return abs(after / before / (new / old) - 1.0) < most
