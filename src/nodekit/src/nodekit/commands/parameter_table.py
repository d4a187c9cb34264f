"""Table of a node's parameters for the terminal."""

import itertools
import math
import textwrap
from typing import Any, Dict, List, Mapping

import yaml

from nodekit.parameters.parameter_types import format_value

#: Width limits of the columns of value and type [characters].
_WIDEST_VALUE = 24
_WIDEST_TYPE = 30
#: Least width of the help beside the other columns, and of the type [characters].
_LEAST = 24
#: Indentation of help below its row.
_BELOW = " " * 6


def as_table(description: List[Dict[str, Any]], width: int) -> str:
    """Return a description as lines of text with aligned columns.

    Long cells are wrapped within their column, and help moves below its row if the line is too
    narrow. Words are not broken, so a long word may exceed the width.

    :param description: the result of :func:`.describe`
    :param width: longest line [characters]
    """
    rows = [
        (
            entry["name"],
            _on_one_line(entry["value"]),
            " ".join(filter(None, (entry["type"], entry["range"], _step(entry), entry["unit"]))),
            entry["help"],
        )
        for entry in description
    ]
    widest = [max((len(row[column]) for row in rows), default=0) for column in range(4)]
    widths = [widest[0], min(widest[1], _WIDEST_VALUE), min(widest[2], _WIDEST_TYPE)]
    # Two spaces before each of the four columns, and "= " between name and value.
    room = width - sum(widths) - 4 * 2 - 2
    is_beside = room >= min(widest[3], _LEAST)
    if not is_beside:
        widths[2] = max(min(widest[2], _LEAST), widths[2] + room + 2)
    lines: List[str] = []
    for name, value, type_text, text in rows:
        cells = [[name], _wrapped(value, widths[1]), _wrapped(type_text, widths[2])]
        cells.append(_wrapped(text, room) if is_beside else [])
        for number, parts in enumerate(itertools.zip_longest(*cells, fillvalue="")):
            first, second, third = (part.ljust(size) for part, size in zip(parts, widths))
            sign = " " if number else "="
            lines.append(f"  {first}  {sign} {second}  {third}  {parts[3]}".rstrip())
        if text and not is_beside:
            lines += textwrap.wrap(text, width, initial_indent=_BELOW, subsequent_indent=_BELOW)
    return "\n".join(lines)


def _wrapped(cell: str, width: int) -> List[str]:
    if len(cell) <= width:
        return [cell]
    return textwrap.wrap(cell, width, break_long_words=False, break_on_hyphens=False)


def _on_one_line(value: Any) -> str:
    """Return a value as YAML on one line, with line breaks in text escaped."""
    style = '"' if isinstance(value, str) and "\n" in value else None
    text = yaml.safe_dump(value, default_flow_style=True, default_style=style, width=math.inf)
    return text.split("\n")[0]


def _step(entry: Mapping[str, Any]) -> str:
    return f"step {format_value(entry['step'])}" if "step" in entry else ""
