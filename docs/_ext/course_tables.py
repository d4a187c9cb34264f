"""The directive ``{courses} DOCUMENT``: what a course has, and what to type here."""

import csv
import re
from pathlib import Path
from typing import Any, Dict, List

from docutils import nodes
from sphinx.util.docutils import SphinxDirective
from .tables import table

HEADERS = ["Item", "In the course", "Here", "Proved by"]


class CourseTable(SphinxDirective):
    """One row for each item of courses.csv that is from a document."""

    required_arguments = 1

    def run(self) -> List[nodes.Node]:
        path = Path(self.env.srcdir, "courses.csv")
        self.env.note_dependency(str(path))
        with path.open(encoding="utf-8", newline="") as file:
            items = [row for row in csv.DictReader(file) if row["document"] == self.arguments[0]]
        if not items:
            raise self.error(f"{path} has no item of the document {self.arguments[0]}")
        return [table(HEADERS, [_row(item) for item in items])]


def _row(item: Dict[str, str]) -> List[str]:
    return [item["id"], item["command"], item["ours"], _short(item["test"])]


def _short(test: str) -> str:
    """Say in few words where a test is: its package, or its folder, and its name."""
    found = re.match(r"src/(\w+)/.*/", test)
    return f"{found[1]}: `{test[found.end() :]}`" if found else f"`{test}`"


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("courses", CourseTable)
    return {"parallel_read_safe": True}
