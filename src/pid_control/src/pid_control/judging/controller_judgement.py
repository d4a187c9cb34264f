"""Judgement of a controller: metrics of its scenarios against limits, and causes of failures."""

from typing import List, Optional, Sequence

from pid_control.judging.diagnosis import FATAL, FLAWS, Figures, cause_of, cause_of_failure
from pid_control.judging.evidence import evidence_of
from pid_control.judging.metrics import METRICS, SCENARIO_METRICS, metrics_of
from pid_control.judging.record import ENDED, Record
from pid_control.verdicts.judgement import (
    FAILED,
    NOT_JUDGED,
    PASSED,
    Failure,
    Finding,
    Judgement,
    found,
    text_of,
)
from pid_control.verdicts.limits import Limits

#: Flaws that a simulated clock may cause: a run by the machine's clock shows whether it does.
_OF_CLOCK = ("machine clock", "division by 0")


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
    return any(flaw in FATAL for flaw in judge([record], limits).flaws())


def _found(scenario: str, metric: str, value: Optional[float], limits: Limits) -> Finding:
    one = METRICS[metric]
    return found(scenario, metric, value, limits, one.label, one.unit, one.is_least)
