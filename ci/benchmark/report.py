"""The results for people, and for programs."""

import json
import pathlib
from typing import Dict, List

from .analysis import CONFIDENCE, Interval, confidence, interval
from .goals import GOALS, Goal, Outcome, number
from .machine import STOLEN
from .results import Results, table

#: The rates at which pairs are measured, by measurement.
RATES = [
    ("latency-1khz", "1 kHz"),
    ("host-1khz", "1 kHz, in one process"),
    ("latency-500hz", "500 Hz"),
    ("latency-100hz", "100 Hz"),
    ("latency-50hz", "50 Hz"),
    ("latency-10hz", "10 Hz"),
]


def tables(
    results: Results, wanted: List[str], machine: Dict[str, str], left_out: Dict[str, str]
) -> str:
    """Return all there is to read, in Markdown.

    :param wanted: the measurements whose goals are shown
    :param machine: what is known about it
    :param left_out: why a peer was left out, by its name
    """
    goals = [["what", "goal", "figure", "ratio", "95 % in", "turns", ""]]
    goals += [_row(goal, results) for goal in GOALS if goal.measurement in wanted]
    notes = [f"{what} is left out: {why}." for what, why in left_out.items()]
    notes += [
        f"{name}: {count} turns are left out, in which the host took more than "
        f"{100 * STOLEN:g} % of the time."
        for name, count in results.disturbed.items()
    ]
    notes += ["FAILED: " + failure for failure in results.failures]
    facts = [["machine", ""]]
    facts += [[name, value] for name, value in machine.items()]
    tables_of_all = [pairs_table(results), figures_table(results), table(facts)]
    return "\n\n".join([table(goals), *notes, *filter(None, tables_of_all)])


def _row(goal: Goal, results: Results) -> List[str]:
    verdict = goal.judge(results)
    if verdict is None:
        disturbed = results.disturbed[goal.measurement]
        word = Outcome.NOT_MEASURABLE.value if disturbed else ""
        return [goal.what, goal.text, "not measured", "", "", "0", word]
    ratio = number(verdict.value) if verdict.is_ratio else ""
    return [
        goal.what,
        goal.text,
        verdict.figure,
        ratio,
        _in_words(verdict.interval, verdict.turns),
        str(verdict.turns),
        verdict.outcome.value,
    ]


def pairs_table(results: Results) -> str:
    """Return hop and processor time of each pair at each rate; empty where there is none."""
    rows = [["pair at", "of", "p50, us", "95 % in", "CPU, %", "95 % in", "turns"]]
    for measurement, rate in RATES:
        for name, subject in results.subjects():
            if name == measurement:
                p50, cpu = (
                    _with_interval(results, name, subject, figure)
                    for figure in ("p50_us", "cpu_percent")
                )
                rows.append([rate, subject, *p50, *cpu, str(results.turns(name, subject))])
    return table(rows) if rows[1:] else ""


def _with_interval(results: Results, measurement: str, subject: str, figure: str) -> List[str]:
    if figure not in results.medians(measurement, subject):
        return ["", ""]
    values = results.values(measurement, subject, figure)
    return [
        number(results.median(measurement, subject, figure)),
        _in_words(interval(values), len(values)),
    ]


def _in_words(where: Interval, turns: int) -> str:
    """Return an interval, and how sure it is where that is less than the head of the table says."""
    low, high = map(number, where)
    if low == high:
        return ""
    sure = confidence(turns)
    return f"{low} to {high}" + (f" ({100.0 * sure:.0f} %)" if sure < CONFIDENCE else "")


def figures_table(results: Results) -> str:
    """Return the medians of everything that was measured."""
    rows = [["measurement", "of", "medians"]]
    for measurement, subject in results.subjects():
        medians = results.medians(measurement, subject)
        figures = ", ".join(f"{name} {number(value)}" for name, value in medians.items())
        rows.append([measurement, subject, figures])
    return table(rows)


def write_json(
    file: pathlib.Path, results: Results, machine: Dict[str, str], left_out: Dict[str, str]
) -> None:
    """Write everything that is known."""
    goals = []
    for goal in GOALS:
        verdict = goal.judge(results)
        goals.append(
            {
                "what": goal.what,
                "goal": goal.text,
                "limit": goal.limit,
                **(
                    {}
                    if verdict is None
                    else {**verdict._asdict(), "outcome": verdict.outcome.value}
                ),
            }
        )
    content = {
        "machine": machine,
        "left_out": left_out,
        "failures": results.failures,
        "disturbed": results.disturbed,
        "goals": goals,
        "runs": results.as_json(),
        "conditions": results.conditions,
    }
    file.write_text(json.dumps(content, indent=1) + "\n")
