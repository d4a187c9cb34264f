"""What was found, against what is demanded, for people and for programs."""

import json
import pathlib
from typing import Any, Dict, List, NamedTuple

from ..benchmark.results import table as rows_as_table


class Check(NamedTuple):
    """One figure and its bound."""

    what: str
    bound: str
    figure: str
    passed: bool


def at_most(what: str, value: float, limit: float, unit: str = "") -> Check:
    """Demand that a figure does not exceed a limit."""
    return Check(what, "<= " + _text(limit, unit), _text(value, unit), value <= limit)


def at_least(what: str, value: float, limit: float, unit: str = "") -> Check:
    """Demand that a figure reaches a limit."""
    return Check(what, ">= " + _text(limit, unit), _text(value, unit), value >= limit)


def none_of(what: str, found: List[str]) -> Check:
    """Demand that nothing of a kind was found; the first few are shown."""
    figure = "0" if not found else f"{len(found)}: {'; '.join(found[:3])}"
    return Check(what, "0", figure, not found)


def reported(what: str, figure: str) -> Check:
    """Report a figure that has no bound."""
    return Check(what, "", figure, True)


def _text(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}".strip()


def table(results: Dict[str, List[Check]]) -> str:
    """Return all checks in Markdown.

    :param results: the checks of each run, by its name
    """
    rows = [["run", "what", "bound", "figure", ""]]
    for name, checks in results.items():
        for check in checks:
            verdict = "" if not check.bound else "pass" if check.passed else "SHORT"
            rows.append([name, check.what, check.bound, check.figure, verdict])
    return rows_as_table(rows)


def write_json(
    file: pathlib.Path, results: Dict[str, List[Check]], machine: Dict[str, str]
) -> None:
    """Write all checks and what is known about the machine."""
    content: Dict[str, Any] = {"machine": machine, "runs": {}}
    for name, checks in results.items():
        content["runs"][name] = [check._asdict() for check in checks]
    file.write_text(json.dumps(content, indent=1) + "\n")


def all_kept(results: Dict[str, List[Check]]) -> bool:
    """Tell whether something was checked, and every bound kept."""
    checks = [check for of_run in results.values() for check in of_run]
    return bool(checks) and all(check.passed for check in checks)
