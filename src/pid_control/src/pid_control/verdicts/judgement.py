"""Judgement of a submission: measured values and their limits, failures, and their causes."""

import math
from typing import Dict, List, NamedTuple, Optional, Sequence

from pid_control.verdicts.limits import Limits

PASSED, FAILED, NOT_JUDGED = "passed", "failed", "not judged"
#: Exit status of each verdict.
STATUS = {PASSED: 0, FAILED: 1, NOT_JUDGED: 125}
#: Messages have float32 values.
_ROUNDING = 1e-6


class Cause(NamedTuple):
    """The cause of a failure.

    :ivar flaw: short name
    :ivar sentence: description and remedy
    """

    flaw: str
    sentence: str


class Finding(NamedTuple):
    """A figure and its limit.

    :ivar scenario: name of the scenario
    :ivar metric: name of the metric
    :ivar value: the figure; None if not measurable
    :ivar limit: the limit, if any
    :ivar passed: True if the figure is within its limit
    :ivar label: text for reports
    :ivar unit: unit of the figure
    :ivar is_least: True if the limit is a minimum, not a maximum
    """

    scenario: str
    metric: str
    value: Optional[float]
    limit: Optional[float]
    passed: bool
    label: str
    unit: str = ""
    is_least: bool = False


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


def found(
    scenario: str,
    metric: str,
    value: Optional[float],
    limits: Limits,
    label: str,
    unit: str = "",
    is_least: bool = False,
) -> Finding:
    """Compare a figure with its limit; a figure that is not measurable passes.

    :param scenario: name of the scenario
    :param metric: name of the metric
    :param value: the figure; None if not measurable
    :param limits: all limits
    :param label: text for reports
    :param unit: unit of the figure
    :param is_least: True if the limit is a minimum, not a maximum
    """
    limit = limits.get(scenario, {}).get(metric)
    passed = True
    if value is not None and limit is not None:
        passed = value >= limit - _ROUNDING if is_least else value <= limit + _ROUNDING
    return Finding(scenario, metric, value, limit, passed, label, unit, is_least)


def text_of(finding: Finding) -> str:
    """Return the text of a figure and its limit."""
    allowed = "at least" if finding.is_least else "at most"
    limit = number(finding.limit, finding.unit)
    return f"{finding.label} {number(finding.value, finding.unit)}, {allowed} {limit}"


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
