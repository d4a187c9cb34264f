"""How robots are, as a table."""

from typing import List, Sequence

from robot_interfaces_demo.monitoring.robot import Finding

_COLUMNS = ("presence", "age", "period", "mode", "battery", "temperature", "obstacle")


def as_table(findings: Sequence[Finding]) -> str:
    """Return findings as lines of text with aligned columns.

    :param findings: of the fleet, then of each robot
    """
    fleet, *robots = findings
    rows: List[List[str]] = [["robot", "level", *_COLUMNS, "message"]]
    for name, level, message, values in robots:
        cells = (values.get(column, "-") for column in _COLUMNS)
        rows.append([name, level.name, *cells, message])
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows if robots]
    return "\n".join([*lines, f"{fleet.level.name}: {fleet.message}"])
