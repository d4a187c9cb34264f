"""Build document tables from rows of text; what is between backquotes becomes code."""

import re
from typing import List, Sequence

from docutils import nodes


def inline(text: str) -> List[nodes.Node]:
    """Turn text into document nodes.

    :param text: plain text with ``code`` between single backquotes
    """
    parts = re.split(r"`([^`]+)`", text)
    return [
        nodes.literal(part, part) if index % 2 else nodes.Text(part)
        for index, part in enumerate(parts)
        if part
    ]


def paragraph(text: str) -> nodes.paragraph:
    """Return a paragraph of text as :func:`inline` takes it."""
    return nodes.paragraph("", "", *inline(text))


def table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> nodes.table:
    """Build a table.

    :param headers: one for each column
    :param rows: cells as :func:`inline` takes them, one for each column
    """
    group = nodes.tgroup("", cols=len(headers))
    group += [nodes.colspec(colwidth=_width(index, rows)) for index in range(len(headers))]
    group += nodes.thead("", _row(headers))
    group += nodes.tbody("", *[_row(row) for row in rows])
    return nodes.table("", group, classes=["docutils", "align-default"])


def _width(index: int, rows: Sequence[Sequence[str]]) -> int:
    return max([len(row[index]) for row in rows] + [5])


def _row(cells: Sequence[str]) -> nodes.row:
    return nodes.row("", *[nodes.entry("", paragraph(cell)) for cell in cells])
