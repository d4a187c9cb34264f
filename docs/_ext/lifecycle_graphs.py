"""The directive ``{lifecycle-graph}``: a picture of the states of managed nodes.

It is drawn from the table that the nodes themselves go by, so it cannot show anything else.
"""

from typing import Any, Dict, Iterator, List

from docutils import nodes
from sphinx.ext.graphviz import graphviz
from sphinx.util.docutils import SphinxDirective

from nodekit import lifecycle_states as table

#: Colour of the line for each outcome of a callback.
COLOURS = {
    table.Outcome.SUCCESS: "#2e7d32",
    table.Outcome.FAILURE: "#b26a00",
    table.Outcome.ERROR: "#c62828",
}


class LifecycleGraph(SphinxDirective):
    """States as ellipses, dashed where a callback is under way; transitions as arrows."""

    def run(self) -> List[nodes.Node]:
        self.env.note_dependency(str(table.__file__))
        picture = graphviz()
        picture["code"] = "\n".join(_lines())
        picture["options"] = {}
        picture["alt"] = "the states of managed nodes and the transitions between them"
        return [picture]


def _lines() -> Iterator[str]:
    yield "digraph lifecycle {"
    yield 'bgcolor=transparent; node [fontname="sans-serif" fontsize=11]'
    yield 'edge [fontname="sans-serif" fontsize=9]'
    under_way = {state for state, _ in table.OUTCOMES}
    for state in table.STATES:
        if state != table.UNKNOWN:  # which no transition leads to
            style = "dashed" if state in under_way else "bold"
            yield f'{state.label} [label="{state.label}\\n{state.id}" style={style}]'
    for request in table.REQUESTS:
        yield _arrow(request, "#555555", f"{request.label} {request.id}")
    for (_, outcome), transition in table.OUTCOMES.items():
        yield _arrow(transition, COLOURS[outcome], str(transition.id))
    yield "}"


def _arrow(transition: table.Transition, colour: str, label: str) -> str:
    ends = f"{transition.start.label} -> {transition.goal.label}"
    return f'{ends} [label="{label}" color="{colour}" fontcolor="{colour}"]'


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("lifecycle-graph", LifecycleGraph)
    return {"parallel_read_safe": True}
