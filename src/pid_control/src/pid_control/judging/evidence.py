"""Evidence of a controller's gains, limits and faults, such as windup, from its records."""

import functools
import math
from statistics import median
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

from pid_control.judging.metrics import growths, leave_times, metrics_of
from pid_control.judging.probes import ProbeFit, best_fit, first_change, is_constant, is_ignored
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, RATE_PARTS, STAYS, Scenario, scaled
from pid_control.judging.simulation import pi_law, simulate

#: Relative difference of two answers that are equal.
_EQUAL = 0.1
#: Shares of the proportional answer below which an integral, or a leap, does not count.
_NONE, _LEAP = 1e-3, 0.2
#: Growth of the time at a limit by which the integral has grown there, as a share of the time.
_GROWN = 0.3
#: Time in which a limited input is constant [s], and the largest limit that may be the motor's.
_FLAT_S, _MOTORS = 0.2, 1.05
#: Share of a limit above which a value is beyond it.
_BEYOND = 1.01
#: Smallest relative change of a growth that counts [1].
_CHANGED = 0.25
#: Shortest time without a change that counts as a late start, and its largest difference between
#: runs [s].
_LATE_S, _SAME_S = 1.0, 0.5
#: Times before and after a step of the set point [s], least answer to it [1/(rad/s)], and share of
#: the largest input below which there is no limit.
_BEFORE_S, _AFTER_S, _LEAST_ANSWER, _FREE = 0.05, 0.2, 1e-3, 0.9
#: Settling time and overshoot of a law that suits the motor [s, %].
_SETTLED_S, _OVERSHOT = 0.8, 25.0


class Law(NamedTuple):
    """PI law that explains a controller's answers while the motor is held.

    :ivar gain: kp [1/(rad/s)]
    :ivar growth: ki [1/rad]
    :ivar period: time between two answers [s]
    :ivar least: lower limit of the input
    :ivar largest: upper limit of the input
    """

    gain: float
    growth: float
    period: float
    least: float = -1.0
    largest: float = 1.0


class ControllerEvidence(NamedTuple):
    """Properties of a control law, from the records. Each is measured, or None or False.

    :ivar was_measured: True if there is a complete record
    :ivar was_probed: True if small errors were tried
    :ivar starts_at: time of the input's first change, if that is late in each run, whatever the
        error [s]
    :ivar ignores: topics on which the input does not depend
    :ivar law: the PI law; None if its answers do not fit one, or it has a derivative
    :ivar wrong_signs: topics to which the input answers the wrong way for errors of both signs
    :ivar wrong_above: True if it does so only for errors above 0, False if only below
    :ivar lacks_integral: True if the input is constant while the error is
    :ivar has_derivative: True if the input leaps at a step of the error
    :ivar grows_per_turn: True if the integral grows with each iteration, not with time
    :ivar winds_up: True if the input leaves its limit the later the longer it was there
    :ivar own_limit: limit at which the input stays on both sides, if it is not the motor's
    :ivar is_in_other_units: True if the law suits the motor when it is divided by own_limit
    :ivar beyond: sides on which the input exceeds 1, of "above" and "below"
    """

    was_measured: bool = False
    was_probed: bool = False
    starts_at: Optional[float] = None
    ignores: Tuple[str, ...] = ()
    law: Optional[Law] = None
    wrong_signs: Tuple[str, ...] = ()
    wrong_above: Optional[bool] = None
    lacks_integral: bool = False
    has_derivative: bool = False
    grows_per_turn: bool = False
    winds_up: bool = False
    own_limit: Optional[float] = None
    is_in_other_units: bool = False
    beyond: Tuple[str, ...] = ()


def evidence_of(records: Sequence[Record]) -> ControllerEvidence:
    """Return the evidence in all records that are complete.

    :param records: the records
    """
    by_name = {record.scenario.name: record for record in records if not record.failure}
    beyond = _sides_beyond(list(by_name.values()))
    evidence = ControllerEvidence(
        was_measured=bool(by_name), beyond=beyond, starts_at=_late_start(list(by_name.values()))
    )
    if "held" in by_name:
        evidence = _with_probes(evidence, by_name["held"])
    if {"held", "steps"} <= by_name.keys() and "set_point" not in evidence.ignores:
        if _ignores_steps(by_name["held"], by_name["steps"]):
            evidence = evidence._replace(ignores=("set_point", *evidence.ignores))
    if "rate" in by_name:
        evidence = evidence._replace(grows_per_turn=_grows_per_turn(by_name["rate"]))
    if "windup" in by_name:
        evidence = _with_limits(evidence, by_name["windup"])
    return evidence


def adapted(scenario: Scenario, records: Sequence[Record]) -> Scenario:
    """Return a scenario with errors adapted to the controller's answers in ``held``, if known.

    :param scenario: the next scenario
    :param records: records of those before it
    """
    held = [record for record in records if record.scenario.name == "held" and not record.failure]
    fit = best_fit(held[0].answers, False) or best_fit(held[0].answers, True) if held else None
    return scenario if fit is None else scaled(scenario, fit.gain, fit.growth)


def faultless_figures(law: Law, scenario: str) -> Dict[str, Optional[float]]:
    """Return the figures of a faultless controller with a law.

    :param law: the law; its input is limited, and its integral does not wind up
    :param scenario: name of the scenario
    """
    return dict(_figures(law, scenario))


@functools.lru_cache(maxsize=256)
def _figures(law: Law, scenario: str) -> Tuple[Tuple[str, Optional[float]], ...]:
    played = pi_law(law.gain, law.growth, law.least, law.largest)
    return tuple(metrics_of(simulate(BY_NAME[scenario], played, law.period)).items())


def _late_start(records: Sequence[Record]) -> Optional[float]:
    """Return when the input first changes [s], if late, and at the same time in each run.

    Only a closed loop's error lasts until the controller answers, so one must be among the runs.
    """
    changes = {record.scenario.name: first_change(record.answers) for record in records}
    runs = [record.scenario for record in records if changes[record.scenario.name] < math.inf]
    begin, end = (pick((changes[run.name] for run in runs), default=0.0) for pick in (min, max))
    is_late = begin >= _LATE_S and end - begin <= _SAME_S
    return begin if is_late and any(run.held_speed is None for run in runs) else None


def _sides_beyond(records: Sequence[Record]) -> Tuple[str, ...]:
    values = [value for record in records for _, value in record.answers if math.isfinite(value)]
    sides = {"above": max(values, default=0.0), "below": -min(values, default=0.0)}
    return tuple(side for side, value in sides.items() if value > 1.0 + 1e-6)


def _with_probes(evidence: ControllerEvidence, record: Record) -> ControllerEvidence:
    topics = {"set_point": False, "motor_output": True}
    ignores = tuple(
        topic for topic, is_output in topics.items() if is_ignored(record.answers, is_output)
    )
    fits = {topic: best_fit(record.answers, is_output) for topic, is_output in topics.items()}
    known = [fit for fit in fits.values() if fit is not None]
    wrong = tuple(topic for topic, fit in fits.items() if fit and max(fit.response()) < 0.0)
    evidence = evidence._replace(
        was_probed=True, ignores=ignores, wrong_signs=wrong, wrong_above=_one_sided(known)
    )
    if len(known) < len(topics) or wrong or evidence.wrong_above is not None:
        return evidence
    gains, integrals = [fit.gain for fit in known], [fit.growth for fit in known]
    period = median(b[0] - a[0] for a, b in zip(record.answers, record.answers[1:]))
    has_derivative = any(fit.leap > _LEAP * abs(fit.gain) for fit in known)
    is_pi = _are_equal(gains) and _are_equal(integrals) and not has_derivative
    is_symmetric = all(fit.gain == fit.gain_below for fit in known)
    return evidence._replace(
        has_derivative=has_derivative,
        lacks_integral=all(abs(fit.growth) * 0.1 < _NONE * abs(fit.gain) for fit in known),
        law=Law(gains[0], integrals[0], period) if is_pi and is_symmetric else None,
    )


def _ignores_steps(held: Record, closed: Record) -> bool:
    """Return True if the input does not depend on the set point, also where it is at no limit."""
    has_started = first_change(closed.answers) < _SETTLED_S
    if not has_started or not is_constant(held.answers, is_output=False):
        return False
    largest = max(abs(value) for _, value in held.answers)
    corners = closed.scenario.set_point
    steps = [(time, value - before) for (_, before), (time, value) in zip(corners, corners[1:])]
    for time, height in (one for one in steps if one[1] and one[0] > _SETTLED_S):
        near = [row.input for row in closed.between(time - _BEFORE_S, time + _AFTER_S)]
        is_same = max(near) - min(near) <= _LEAST_ANSWER * abs(height)
        if not is_same or max(abs(value) for value in near) > _FREE * largest:
            return False
    return True


def _one_sided(fits: Sequence[ProbeFit]) -> Optional[bool]:
    """Return True if all answers have the wrong sign above 0 only, False if below 0 only."""
    above = [fit.response()[0] < 0.0 for fit in fits]
    below = [fit.response()[1] < 0.0 for fit in fits]
    if fits and all(above) and not any(below):
        return True
    return False if fits and all(below) and not any(above) else None


def _are_equal(values: Sequence[float]) -> bool:
    return max(values) - min(values) <= _EQUAL * max(abs(value) for value in values) + 1e-9


def _grows_per_turn(record: Record) -> bool:
    found = growths(record)
    if found is None or abs(found[1] / found[0] - 1.0) < _CHANGED:
        return False
    turns = [_period(record, RATE_PARTS[index]) for index in (1, 3)]
    return _are_equal([found[0] * turns[0], found[1] * turns[1]])


def _period(record: Record, part: Tuple[float, float, float]) -> float:
    times = [time for time, _ in record.answers if part[0] + 0.2 <= time < part[1]]
    # The mean: rospy.Rate catches up with iterations at the same time.
    return (times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else math.nan


def _with_limits(evidence: ControllerEvidence, record: Record) -> ControllerEvidence:
    left = leave_times(record)
    stays = [end - begin for begin, end, _ in STAYS]
    # The longer stay is first: a delay that grows with time cannot explain it.
    grown = [left[i] - left[i + 1] > _GROWN * (stays[i] - stays[i + 1]) for i in (0, 2)]
    evidence = evidence._replace(winds_up=any(grown))
    ends: List[float] = []
    for _, end, sign in STAYS:
        values = [row.input * sign for row in record.between(end - _FLAT_S, end)]
        if max(values) - min(values) > 1e-6 * max(abs(value) for value in values):
            return evidence  # the input still changes: no limit
        ends.append(values[-1])
    law = evidence.law
    if law is not None and min(ends) > 0.0:
        limited = law._replace(least=-min(1.0, ends[2]), largest=min(1.0, ends[0]))
        evidence = evidence._replace(law=limited)
    if min(ends) < _MOTORS or not _are_equal(ends):
        return evidence
    limit = ends[0]
    if max(abs(value) for _, value in record.answers if math.isfinite(value)) > _BEYOND * limit:
        return evidence  # as of P alone: it is constant because the error is
    is_scaled = law is not None and _suits(_divided(law, limit)) and not _suits(law)
    return evidence._replace(own_limit=limit, is_in_other_units=is_scaled)


def _divided(law: Law, unit: float) -> Law:
    return law._replace(gain=law.gain / unit, growth=law.growth / unit)


def _suits(law: Law) -> bool:
    """Return True if a faultless controller with a law follows steps."""
    figures = faultless_figures(law, "steps")
    settling, overshoot = figures["settling_time"], figures["overshoot"]
    return (settling or 0.0) <= _SETTLED_S and (overshoot or 0.0) <= _OVERSHOT
