"""Check that code, texts, commands and pages outside nodekit name only its public modules."""

import pathlib
import re
from typing import Iterator, Tuple

from .structure import ROOMS

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
#: Public modules besides the names in nodekit's ``__init__``; docs/api.md describes each.
PUBLIC = (
    "entry_point",
    "lifecycle_states",
    "master",
    "master_process",
    "message_definitions",
    "package_version",
    "service_hint",
    "testing",
)
#: nodekit itself, lists of its folders and their tests, and a measurement of its parts.
INSIDE = (
    "src/nodekit/scripts/",
    "src/nodekit/src/",
    "src/nodekit/test/",
    "ci/benchmark/call_costs.py",  # measures the queue of an executor by itself
    "ci/lint/",
    "ci/mutation/",
    "ci/tests/lint/",
    "ci/tests/mutation/",
)
#: Suffixes of the files that are read; scripts have the empty one.
SUFFIXES = ("", ".py", ".md", ".bash", ".launch", ".test")
_ROOMS = "|".join(room for room in ROOMS["nodekit"] if room not in PUBLIC)
#: Not the argument of a directive, which inserts the documentation of a public module.
_NAMED = re.compile(
    rf"(?<!:: )\bnodekit\.({_ROOMS})\b|\bfrom nodekit import (?:\([^)]*|[\w, ]*)\b({_ROOMS})\b"
)


def named(text: str) -> Iterator[Tuple[int, str]]:
    """Return line and name wherever a text names a private folder of nodekit."""
    for found in _NAMED.finditer(text):
        yield text.count("\n", 0, found.end()) + 1, found.group(1) or found.group(2)


def breaches() -> Iterator[str]:
    """Return a line for each use of nodekit's private modules outside of it."""
    for folder in ("src", "ci", "docs"):
        for path in sorted((WORKSPACE / folder).rglob("*")):
            place = path.relative_to(WORKSPACE).as_posix()
            if path.suffix in SUFFIXES and path.is_file() and not place.startswith(INSIDE):
                for line, room in named(path.read_text("utf-8")):
                    yield f"{place}:{line}: nodekit.{room} is not public: see docs/api.md"
