"""Keeps the pages that show the graph up to date."""

from typing import Any, Callable, Dict, Optional

from topic_scope.graph.background import Background
from topic_scope.graph.bus import Bus
from topic_scope.graph.graph import Rates, message
from topic_scope.graph.master_watch import GraphState


class GraphFeed:
    """Makes the graph, with rates as long as somebody looks; in the thread of the web.

    :param name: name of the scope's node, which is left out
    :param background: where to wait for nodes
    :param tell: passes the graph on to the pages that show it
    """

    def __init__(
        self, name: str, background: Background, tell: Callable[[Dict[str, Any]], None]
    ) -> None:
        self._name, self._background, self._tell = name, background, tell
        self._bus = Bus(name)
        self._rates = Rates()
        self._state: Optional[GraphState] = None

    def message(self) -> Optional[Dict[str, Any]]:
        """Return the graph, None as long as it is not known."""
        return message(self._state, self._rates, self._name) if self._state else None

    def on_state(self, state: GraphState, is_shown: bool) -> None:
        """Take note of what is on the graph.

        :param state: what the master knows
        :param is_shown: whether a page shows it
        """
        self._state = state
        if is_shown:
            nodes = {node for _, names in state.publishers for node in names} - {self._name}
            self._background.run("bus", lambda: self._bus.ask(nodes), self._on_counts)
        else:
            self._rates = Rates()

    def _on_counts(self, answers: Any) -> None:
        if not isinstance(answers, Exception):
            self._rates.keep(set(answers))
            for node, (when, statistics) in answers.items():
                self._rates.add_counts(node, statistics, when)
        graph = self.message()
        if graph is not None:
            self._tell(graph)
