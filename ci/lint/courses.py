"""Compare docs/courses.csv, the items of the courses, with the tests that prove them.

A test names the items that it proves in its docstring, "Course ID, ID."; a page with commands that
the tests type, in a comment.
"""

import csv
import pathlib
import re
from typing import Dict, Iterator, List, Set

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]

#: Anything that begins like an id counts as one, to find typing errors.
_ID = r"(?:00\d|err)-\w+(?:-\w+)*"
_LIST = re.compile(rf"\bCourses?\s+{_ID}(?:,\s+{_ID})*")


def rows(text: str) -> List[Dict[str, str]]:
    """Return the items of the courses.

    :param text: content of docs/courses.csv
    """
    return list(csv.DictReader(text.splitlines(), strict=True))


def proofs(workspace: pathlib.Path) -> Iterator[pathlib.Path]:
    """Return all files that may name an id: the tests, and the pages that tests type."""
    for pattern in ("src/*/test/**/*.py", "ci/tests/**/*.py", "docs/**/*.md"):
        yield from sorted(workspace.glob(pattern))


def carried(path: pathlib.Path) -> Set[str]:
    """Return the ids that a file names."""
    lists = " ".join(_LIST.findall(path.read_text("utf-8")))
    return set(re.findall(_ID, lists))


def breaches(items: List[Dict[str, str]], workspace: pathlib.Path) -> Iterator[str]:
    """Return a message for each difference between the rows and the tests.

    :param items: the rows
    :param workspace: folder with the tests
    """
    found = {str(path.relative_to(workspace)): carried(path) for path in proofs(workspace)}
    known = [row["id"] for row in items]
    for identifier in sorted({name for name in known if known.count(name) > 1}):
        yield f"docs/courses.csv: {identifier} has more than one row"
    for path, ids in found.items():
        for identifier in sorted(ids - set(known)):
            yield f"{path}: {identifier} is not an id in docs/courses.csv"
    for row in items:
        identifier, test = row["id"], row["test"]
        if test and identifier not in found.get(test, ()):
            yield f"{identifier}: {test} does not carry it, or is not a test of the workspace"
        if not test:
            carriers = [path for path, ids in found.items() if identifier in ids]
            yield f"{identifier}: names no test; carried by {', '.join(carriers) or 'none'}"
