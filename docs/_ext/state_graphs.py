"""The directive ``{state-graph} MODULE TABLE``: a picture of a state machine.

The table maps a state and an event, both members of enumerations, to the next state; the code goes
by the same one, so the picture cannot show anything else.
"""

import importlib
from typing import Any, Dict, Iterator, List

from docutils import nodes
from sphinx.ext.graphviz import graphviz
from sphinx.util.docutils import SphinxDirective


class StateGraph(SphinxDirective):
    """States as ellipses, events as arrows from one to the next."""

    required_arguments = 2

    def run(self) -> List[nodes.Node]:
        name, table = self.arguments
        module = importlib.import_module(name)
        self.env.note_dependency(str(module.__file__))
        picture = graphviz()
        picture["code"] = "\n".join(_lines(getattr(module, table)))
        picture["options"] = {}
        picture["alt"] = f"the states of {name} and the events between them"
        return [picture]


def _lines(table: Dict[Any, Any]) -> Iterator[str]:
    yield "digraph states {"
    yield 'rankdir=LR; bgcolor=transparent; node [fontname="sans-serif" fontsize=11]'
    yield 'edge [fontname="sans-serif" fontsize=9]'
    for (state, event), goal in table.items():
        yield f'"{state.value}" -> "{goal.value}" [label="{event.value}"]'
    yield "}"


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("state-graph", StateGraph)
    return {"parallel_read_safe": True}
