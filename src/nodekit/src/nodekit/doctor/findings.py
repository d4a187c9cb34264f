# Pure: knows no ROS.
"""Findings of the checks, and their report."""

import enum
from typing import Iterable, List, NamedTuple


class Level(enum.Enum):
    """Severity of a finding; the value is its word in the report."""

    OK = "ok"
    NOTE = "note"
    FAULT = "fault"


class Finding(NamedTuple):
    """One line of the report.

    :param level: the weight
    :param subject: what was checked: a node, a topic, a file
    :param problem: the observation
    :param remedy: what to do; empty for nothing
    """

    level: Level
    subject: str
    problem: str
    remedy: str = ""

    def __str__(self) -> str:
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"{self.level.value:6}{self.subject}: {self.problem}{remedy}"


def ok(subject: str, state: str) -> Finding:
    """Return a finding without a problem."""
    return Finding(Level.OK, subject, state)


def note(subject: str, problem: str, remedy: str = "") -> Finding:
    """Return a finding that may be intended, or about a check that was not possible."""
    return Finding(Level.NOTE, subject, problem, remedy)


def fault(subject: str, problem: str, remedy: str) -> Finding:
    """Return a finding that keeps the system from working."""
    return Finding(Level.FAULT, subject, problem, remedy)


def report(findings: Iterable[Finding]) -> str:
    """Return one line per finding, faults last, and a line with the number of faults."""
    order = list(Level)
    lines: List[Finding] = sorted(findings, key=lambda finding: order.index(finding.level))
    faults = count_faults(lines)
    total = "healthy" if not faults else "1 fault" if faults == 1 else f"{faults} faults"
    return "\n".join([*map(str, lines), total])


def count_faults(findings: Iterable[Finding]) -> int:
    """Return the number of faults among findings."""
    return sum(finding.level is Level.FAULT for finding in findings)
