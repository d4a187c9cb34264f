"""Judgement of a controller: its figures, failures and their causes."""

import math
from typing import Dict, List, NamedTuple, Optional, Sequence

from pid_control.judging.diagnosis import FLAWS, Cause, Figures, cause_of, cause_of_failure
from pid_control.judging.evidence import evidence_of
from pid_control.judging.limits import Limits
from pid_control.judging.metrics import METRICS, SCENARIO_METRICS, metrics_of
from pid_control.judging.record import ENDED, Record

PASSED, FAILED, NOT_JUDGED = "passed", "failed", "not judged"
#: Exit status of each verdict.
STATUS = {PASSED: 0, FAILED: 1, NOT_JUDGED: 125}
#: Flaws that stop the judgement: the other scenarios would take too long, or say nothing.
_FATAL = ("flood", "restless", "machine clock", "endless output", "silent", "not connected")
#: Flaws that a simulated clock may be the reason of: the machine's shows whether it is.
_OF_CLOCK = ("machine clock", "division by 0")
#: Inputs are float32.
_ROUNDING = 1e-6


class Finding(NamedTuple):
    """A figure and its limit.

    :ivar scenario: name of the scenario
    :ivar metric: name of the metric
    :ivar value: the figure; None if not measurable
    :ivar limit: the limit, if any
    :ivar passed: True if the figure is within its limit
    """

    scenario: str
    metric: str
    value: Optional[float]
    limit: Optional[float]
    passed: bool


class Failure(NamedTuple):
    """A failure in a scenario.

    :ivar scenario: name of the scenario
    :ivar what: the figure and its limit, or the reason of an early end
    :ivar cause: the likely cause
    """

    scenario: str
    what: str
    cause: Cause


class Judgement(NamedTuple):
    """The judgement of a controller.

    :ivar verdict: PASSED, FAILED or NOT_JUDGED
    :ivar findings: all figures
    :ivar failures: the failures, the worst flaws first
    :ivar reason: why the controller was not judged, for NOT_JUDGED
    :ivar left_out: names of the scenarios that the plant does not support
    """

    verdict: str
    findings: List[Finding]
    failures: List[Failure]
    reason: str = ""
    left_out: Sequence[str] = ()

    @property
    def status(self) -> int:
        """The exit status."""
        return STATUS[self.verdict]

    def flaws(self) -> List[str]:
        """Return the names of the flaws, without repetition."""
        return list(dict.fromkeys(failure.cause.flaw for failure in self.failures))


def judge(records: Sequence[Record], limits: Limits, reason: str = "") -> Judgement:
    """Judge a controller by its records.

    :param records: records of its scenarios
    :param limits: limits of the figures
    :param reason: why not all scenarios were run, if so
    """
    figures: Figures = {}
    for record in records:
        if not record.failure:
            for metric, value in metrics_of(record).items():
                figures[record.scenario.name, metric] = value
    evidence = evidence_of(records)
    findings: List[Finding] = []
    failures: List[Failure] = []

    def is_broken(scenario: str, metric: str, figure: Optional[float]) -> bool:
        return not _found(scenario, metric, figure, limits).passed

    for record in records:
        name = record.scenario.name
        if record.failure:
            failures.append(Failure(name, record.failure, cause_of_failure(record)))
            continue
        for metric in SCENARIO_METRICS[name]:
            finding = _found(name, metric, figures[name, metric], limits)
            findings.append(finding)
            if not finding.passed:
                cause = cause_of(name, metric, figures, evidence, is_broken)
                failures.append(Failure(name, text_of(finding), cause))
    failures.sort(key=lambda failure: FLAWS.index(failure.cause.flaw))
    of_clock = [failure for failure in failures if failure.cause.flaw in _OF_CLOCK]
    if of_clock:
        return Judgement(NOT_JUDGED, findings, failures, of_clock[0].cause.sentence)
    if failures:
        return Judgement(FAILED, findings, failures)
    if reason or not findings:
        return Judgement(NOT_JUDGED, findings, failures, reason or "nothing was measured")
    return Judgement(PASSED, findings, failures)


def is_fatal(record: Record, limits: Limits) -> bool:
    """Return True if no further scenario should be run.

    :param record: record of the latest scenario
    :param limits: limits of the figures
    """
    if record.failure == ENDED:
        return not record.answers  # the next scenario may not end it
    return any(flaw in _FATAL for flaw in judge([record], limits).flaws())


def _found(scenario: str, metric: str, value: Optional[float], limits: Limits) -> Finding:
    limit = limits.get(scenario, {}).get(metric)
    passed = True
    if value is not None and limit is not None:
        if METRICS[metric].is_least:
            passed = value >= limit - _ROUNDING
        else:
            passed = value <= limit + _ROUNDING
    return Finding(scenario, metric, value, limit, passed)


def text_of(finding: Finding) -> str:
    """Return the text of a figure and its limit."""
    metric = METRICS[finding.metric]
    allowed = "at least" if metric.is_least else "at most"
    limit = number(finding.limit, metric.unit)
    return f"{metric.label} {number(finding.value, metric.unit)}, {allowed} {limit}"


def number(value: Optional[float], unit: str = "") -> str:
    """Format a figure.

    :param value: the figure, if any
    :param unit: its unit
    """
    if value is None:
        return "-"
    if math.isinf(value):
        return "never" if unit == "s" else "endless"
    if abs(value) < 5e-4:
        value = 0.0
    return f"{value:.3g} {unit}".strip()


def causes(judgement: Judgement) -> Dict[Cause, List[Failure]]:
    """Group the failures by cause, in order of appearance."""
    found: Dict[Cause, List[Failure]] = {}
    for failure in judgement.failures:
        found.setdefault(failure.cause, []).append(failure)
    return found
