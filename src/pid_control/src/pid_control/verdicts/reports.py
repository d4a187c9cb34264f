"""Reports of a judgement: text, CSV and JUnit."""

import csv
import io
from typing import Dict, List, Optional, Sequence, Tuple
from xml.etree import ElementTree

from pid_control.verdicts.judgement import (
    FAILED,
    NOT_JUDGED,
    PASSED,
    Finding,
    Judgement,
    causes,
    number,
)
from pid_control.verdicts.limits import Figures

#: Characters that XML does not allow.
_LEGAL = dict.fromkeys([*range(9), 11, 12, *range(14, 32), 0xFFFE, 0xFFFF], "?")


def as_table(judgement: Judgement) -> str:
    """Return the table of figures.

    :param judgement: the judgement
    """
    rows = [("scenario", "what", "figure", "limit", "")]
    before = ""
    for finding in judgement.findings:
        rows.append(
            (
                finding.scenario if finding.scenario != before else "",
                finding.label,
                number(finding.value, finding.unit),
                _limit(finding),
                "" if finding.passed else "FAILED",
            )
        )
        before = finding.scenario
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def _limit(finding: Finding) -> str:
    if finding.limit is None:
        return ""
    return (">= " if finding.is_least else "<= ") + number(finding.limit)


def as_sentences(judgement: Judgement) -> str:
    """Return the failures, grouped by cause, and the verdict.

    :param judgement: the judgement
    """
    lines: List[str] = []
    for cause, failures in causes(judgement).items():
        lines += [f"{failure.scenario}: {failure.what}" for failure in failures]
        lines += [f"  likely cause ({cause.flaw}): {cause.sentence}", ""]
    if judgement.left_out:
        lines.append(f"not judged with a real plant: {', '.join(judgement.left_out)}")
    tried = len({finding.scenario for finding in judgement.findings})
    if judgement.verdict == PASSED:
        scenarios = f"{tried} scenario" + ("s" if tried > 1 else "")
        lines.append(f"passed: all {len(judgement.findings)} figures of {scenarios}")
    elif judgement.verdict == FAILED:
        lines.append(f"failed: {', '.join(judgement.flaws())}")
    else:
        lines.append(f"not judged: {judgement.reason}")
    return "\n".join(lines)


def as_junit(judgement: Judgement, name: str) -> str:
    """Return a JUnit file with a test case per scenario.

    :param judgement: the judgement
    :param name: name of the controller
    """
    wrong: Dict[str, List[str]] = {}
    for failure in judgement.failures:
        sentence = f"{failure.what}: {failure.cause.sentence}"
        wrong.setdefault(failure.scenario, []).append(sentence)
    scenarios = list(dict.fromkeys([*(one.scenario for one in judgement.findings), *wrong]))
    is_not_judged = judgement.verdict == NOT_JUDGED
    suite = ElementTree.Element(
        "testsuite",
        name="judge",
        tests=str(len(scenarios) + is_not_judged),
        failures=str(len(wrong)),
        errors=str(int(is_not_judged)),
    )
    for scenario in scenarios:
        case = ElementTree.SubElement(suite, "testcase", classname=_legal(name), name=scenario)
        if scenario in wrong:
            text = "\n".join(wrong[scenario])
            failed = ElementTree.SubElement(case, "failure", type=FAILED)
            failed.set("message", _legal(text.splitlines()[0]))
            failed.text = _legal(text)
    if is_not_judged:
        case = ElementTree.SubElement(suite, "testcase", classname=_legal(name), name="judge")
        error = ElementTree.SubElement(case, "error", type="not judged")
        error.set("message", _legal(judgement.reason))
        error.text = _legal(judgement.reason)
    return ElementTree.tostring(suite, encoding="unicode")


def _legal(text: str) -> str:
    return text.translate(_LEGAL)


#: Columns before the figures.
_COLUMNS = ("verdict", "flaws", "why")


def as_csv(
    judgements: Sequence[Tuple[str, Judgement]], figures: Figures, subject: str = "controller"
) -> str:
    """Return a CSV file with a row per judgement and a column per figure.

    :param judgements: name and judgement of each
    :param figures: names of the figures of each scenario
    :param subject: heading of the column with the names
    """
    measured = [(scenario, name) for scenario, names in figures.items() for name in names]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([subject, *_COLUMNS, *(f"{scenario}.{name}" for scenario, name in measured)])
    for name, judgement in judgements:
        values = {(one.scenario, one.metric): one.value for one in judgement.findings}
        cells = [_cell(values.get(key)) for key in measured]
        why = "; ".join(cause.sentence for cause in causes(judgement)) or judgement.reason
        head = [name, judgement.verdict, ", ".join(judgement.flaws()), why]
        writer.writerow([*map(text_cell, head), *cells])
    return text.getvalue()


def _cell(value: Optional[float]) -> str:
    return "" if value is None else f"{value:.6g}"


def text_cell(text: str) -> str:
    """Return a text for a cell of a CSV file, which no spreadsheet parses as a formula."""
    return "'" + text if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text
