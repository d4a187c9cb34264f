"""Figures and their bounds, as a table and as JSON."""

from typing import Any, Dict, List, NamedTuple

from ..benchmark import report


class Check(NamedTuple):
    """One figure and its bound."""

    what: str
    bound: str
    figure: str
    passed: bool


#: The checks of each run, by its name.
Results = Dict[str, List[Check]]


def at_most(what: str, value: float, limit: float, unit: str = "") -> Check:
    """Check that a figure does not exceed a limit."""
    return Check(what, "<= " + _text(limit, unit), _text(value, unit), value <= limit)


def at_least(what: str, value: float, limit: float, unit: str = "") -> Check:
    """Check that a figure reaches a limit."""
    return Check(what, ">= " + _text(limit, unit), _text(value, unit), value >= limit)


def none_of(what: str, found: List[str]) -> Check:
    """Check that nothing was found; show the first few findings."""
    figure = "0" if not found else f"{len(found)}: {'; '.join(found[:3])}"
    return Check(what, "0", figure, not found)


def reported(what: str, figure: str) -> Check:
    """Report a figure without a bound."""
    return Check(what, "", figure, True)


def _text(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}".strip()


def table(results: Results) -> str:
    """Return all checks in Markdown."""
    rows = [["run", "what", "bound", "figure", ""]]
    for name, checks in results.items():
        for check in checks:
            verdict = "" if not check.bound else "pass" if check.passed else "SHORT"
            rows.append([name, check.what, check.bound, check.figure, verdict])
    return report.table(rows)


def as_json(results: Results, machine: Dict[str, str]) -> Dict[str, Any]:
    """Return all checks and facts of the machine."""
    runs = {name: [check._asdict() for check in checks] for name, checks in results.items()}
    return {"machine": machine, "runs": runs}


def all_kept(results: Results) -> bool:
    """Return whether there are checks, and all bounds are kept."""
    checks = [check for of_run in results.values() for check in of_run]
    return bool(checks) and all(check.passed for check in checks)
