"""Promises of docs/compatibility.yaml to users of 1.x, and the current state.

A table has, for each type of interface, entries by name: text, a list of names, or another table.
"""

import pathlib
from typing import Any, Dict, Iterator

import yaml

Table = Dict[str, Any]
FILE = pathlib.Path(__file__).resolve().parents[4] / "docs" / "compatibility.yaml"
HEADING = """\
# What is kept within 1.x: see docs/compatibility.md. dumped_parameters.test of basic_comms
# compares; ci/release adds what is new.
"""


def read(file: pathlib.Path = FILE) -> Table:
    """Return the promises."""
    table: Table = yaml.safe_load(file.read_text("utf-8"))
    return table


def write(table: Table, file: pathlib.Path = FILE) -> None:
    """Write the promises."""
    text = yaml.safe_dump(table, default_flow_style=None, width=100, allow_unicode=True)
    file.write_text(HEADING + text, "utf-8")


def broken(promised: Any, found: Any, place: str = "") -> Iterator[str]:
    """Return a message about each broken promise; additions break none.

    :param place: position in the table
    """
    if isinstance(promised, dict) and isinstance(found, dict):
        for name, value in promised.items():
            path = f"{place}/{name}" if place else str(name)
            if name in found:
                yield from broken(value, found[name], path)
            else:
                yield f"{path} is promised, and is gone"
    elif isinstance(promised, list) and isinstance(found, list):
        for name in promised:
            if name not in found:
                yield f"{place}/{name} is promised, and is gone"
    elif promised != found:
        yield f"{place} is promised as {promised}, and is {found}"


def merged(promised: Any, found: Any) -> Any:
    """Return the promises and the additions."""
    if isinstance(promised, dict) and isinstance(found, dict):
        names = sorted({*promised, *found})
        return {
            name: merged(promised.get(name, found.get(name)), found.get(name, promised.get(name)))
            for name in names
        }
    if isinstance(promised, list) and isinstance(found, list):
        return sorted({*promised, *found})
    return promised
