"""Report of the results as tables in Markdown, and as JSON."""

import json
import pathlib
from typing import Any, Dict, List

from .analysis import CONFIDENCE, Estimate, confidence
from .goals import GOALS, number
from .machine import STOLEN
from .results import Results


def table(rows: List[List[str]]) -> str:
    """Return rows as a table in Markdown; the first row is the head."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = [
        f"| {' | '.join(cell.ljust(width) for cell, width in zip(row, widths))} |" for row in rows
    ]
    lines.insert(1, f"|{'|'.join('-' * (width + 2) for width in widths)}|")
    return "\n".join(lines)


def interval(value: Estimate) -> str:
    """Return an interval, with its confidence if that is less than usual."""
    low, high, sure = number(value.low), number(value.high), confidence(value.turns)
    if low == high:
        return ""
    return f"{low} to {high}" + (f" ({100.0 * sure:.0f} %)" if sure < CONFIDENCE else "")


def tables(
    results: Results, wanted: List[str], facts: Dict[str, str], left_out: Dict[str, str]
) -> str:
    """Return goals, figures, and the facts of the machine.

    :param wanted: the rows with goals to show
    :param left_out: reason for each omitted peer, by its name
    """
    goals = [["row", "what", "goal", "value", "95 % in", "turns", ""]]
    for goal in GOALS:
        if goal.measurement in wanted:
            value = goal.estimate(results)
            cells = ["not measured", "", "0", ""]
            if value is not None:
                outcome = goal.outcome(value).value
                cells = [number(value.median), interval(value), str(value.turns), outcome]
            goals.append([goal.measurement, goal.what, goal.text, *cells])
    figures = [["row", "of", "figure", "median", "95 % in", "turns"]]
    figures += [
        [row, subject, name, number(value.median), interval(value), str(value.turns)]
        for row, subject, name, value in results.estimates()
    ]
    notes = [f"{what} is left out: {why}." for what, why in left_out.items()]
    notes += [
        f"{name}: {count} turns are left out, in which the host took more than "
        f"{100 * STOLEN:g} % of the time."
        for name, count in results.disturbed.items()
    ]
    notes += ["FAILED: " + failure for failure in results.failures]
    machine = table([["machine", ""], *([name, value] for name, value in facts.items())])
    return "\n\n".join([table(goals), *notes, table(figures), machine])


def as_json(results: Results, facts: Dict[str, str], left_out: Dict[str, str]) -> Dict[str, Any]:
    """Return all results and facts."""
    values = ((goal, goal.estimate(results)) for goal in GOALS)
    return {
        "machine": facts,
        "left_out": left_out,
        "failures": results.failures,
        "disturbed": results.disturbed,
        "goals": [
            {
                "row": goal.measurement,
                "what": goal.what,
                "limit": goal.limit,
                "outcome": goal.outcome(value).value,
                **value._asdict(),
            }
            for goal, value in values
            if value is not None
        ],
        "figures": [
            {"row": row, "of": subject, "figure": name, **value._asdict()}
            for row, subject, name, value in results.estimates()
        ],
        "turns": results.as_json(),
    }


def write_json(file: pathlib.Path, content: Dict[str, Any]) -> None:
    """Write the result of :func:`as_json` or of a run of ci/soak."""
    file.write_text(json.dumps(content, indent=1) + "\n")
