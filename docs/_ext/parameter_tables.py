"""The directive ``{parameters} MODULE CLASS``: a table of what a node declares.

The class is a :class:`nodekit.ParameterSet`, the very one that
the node validates by, so the table cannot say anything else than the node does.
"""

import importlib
from typing import Any, Dict, List

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from nodekit import ParameterSet, describe, format_value

from .tables import table

HEADERS = ["Parameter", "Type", "Default", "Allowed", "Unit", "What it is"]


class ParameterTable(SphinxDirective):
    """One row for each parameter of a set, in the order of declaration."""

    required_arguments = 2

    def run(self) -> List[nodes.Node]:
        module_name, class_name = self.arguments
        module = importlib.import_module(module_name)
        self.env.note_dependency(str(module.__file__))
        declaration = getattr(module, class_name)
        if not issubclass(declaration, ParameterSet):
            raise self.error(f"{module_name}.{class_name} declares no parameters")
        return [table(HEADERS, [_row(item) for item in describe(declaration())])]


def _row(item: Dict[str, Any]) -> List[str]:
    default = item["default"]
    return [
        f"`~{item['name']}`",
        item["type"],
        "`%s`" % (default or '""' if isinstance(default, str) else format_value(default)),
        _unbroken(item["range"]) + (f", step {item['step']}" if "step" in item else ""),
        item["unit"],
        item["help"],
    ]


def _unbroken(text: str) -> str:
    """Keep an interval on one line; the words of an enum may go on several."""
    return text.replace(", ", ",\u00a0") if text[:1] in ("(", "[") else text


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("parameters", ParameterTable)
    return {"parallel_read_safe": True}
