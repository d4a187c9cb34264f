"""The directive ``{state-graph} MODULE TABLE``: a picture of a state machine.

The table maps a state and an event to the next state, or to what has it as ``state``. Both are
words, or members of enumerations whose values are. The code goes by the same table, so the picture
cannot show anything else.
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
        goal = getattr(goal, "state", goal)
        yield f'"{_word(state)}" -> "{_word(goal)}" [label="{_word(event)}"]'
    yield "}"


def _word(thing: Any) -> str:
    return str(getattr(thing, "value", thing))


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("state-graph", StateGraph)
    return {"parallel_read_safe": True}
