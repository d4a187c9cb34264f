"""JSON message to pages: graph of nodes and topics, with the message rates of its edges."""

from typing import Any, Callable, Dict, List, Optional, Set, Tuple

from topic_scope.graph.worker import Worker
from topic_scope.graph.master_watch import GraphState
from topic_scope.graph.node_queries import NodeQueries

#: Hidden as in rqt_graph: the log topics and the node that subscribes to them.
LOG_TOPICS = ("/rosout", "/rosout_agg")
LOG_NODE = "/rosout"


class Rates:
    """Message rates from the counts that nodes keep for each connection."""

    def __init__(self) -> None:
        #: By node; then by topic and connection, which both change over time.
        self._counts: Dict[str, Dict[Tuple[str, Any], Tuple[float, int]]] = {}
        self._rates: Dict[str, Dict[str, float]] = {}

    def add_counts(self, node: str, statistics: Any, now: float) -> None:
        """Add a node's message counts.

        :param node: its name
        :param statistics: its reply to ``getBusStats`` of the slave API
            (http://wiki.ros.org/ROS/Slave_API)
        :param now: time of the query [s]
        """
        known, self._counts[node] = self._counts.get(node, {}), {}
        self._rates[node] = {}
        for topic, _, connections in statistics[0]:
            rates = []
            for connection, _, count, *_ in connections:
                then, before = known.get((topic, connection), (now, count))
                self._counts[node][topic, connection] = (now, count)
                if now > then and count >= before:
                    rates.append((count - before) / (now - then))
            if rates:
                self._rates[node][topic] = max(rates)

    def of(self, node: str, topic: str) -> Optional[float]:
        """Return the publishing rate of a node; None if unknown.

        :param node: its name
        :param topic: the topic
        :returns: the rate [Hz]
        """
        return self._rates.get(node, {}).get(topic)

    def keep(self, nodes: Set[str]) -> None:
        """Drop all nodes except these."""
        self._counts = {node: counts for node, counts in self._counts.items() if node in nodes}
        self._rates = {node: rates for node, rates in self._rates.items() if node in nodes}


def graph_message(state: GraphState, rates: Rates, without: str) -> Dict[str, Any]:
    """Return the graph as a message for pages.

    :param state: snapshot of the master
    :param rates: rates of the edges
    :param without: name of a node to leave out: the scope itself, which subscribes to everything
    """
    hidden = (LOG_NODE, without)
    published = _pairs(state.publishers, hidden)
    subscribed = _pairs(state.subscribers, hidden)
    sources = {topic for topic, _ in published}
    targets: Dict[str, List[Optional[str]]] = {}
    for topic, node in subscribed:
        targets.setdefault(topic, []).append(node)
    services = _pairs(state.services, hidden)
    nodes = {node for nodes in (published, subscribed, services) for _, node in nodes}
    topics = sources | set(targets)
    # A topic with one end has an edge with one end.
    edges: List[Dict[str, Any]] = [
        {"from": source, "to": target, "topic": topic, "rate": rates.of(source, topic)}
        for topic, source in published
        for target in targets.get(topic, [None])
    ]
    edges += [
        {"from": None, "to": node, "topic": topic, "rate": None}
        for topic, node in subscribed
        if topic not in sources
    ]
    return {
        "type": "graph",
        "nodes": sorted(nodes),
        "topics": [
            {"name": name, "datatype": state.types.get(name, "*")} for name in sorted(topics)
        ],
        "edges": edges,
    }


def _pairs(registrations: Any, hidden: Tuple[str, ...]) -> List[Tuple[str, str]]:
    return [
        (name, node)
        for name, nodes in sorted(registrations)
        for node in sorted(nodes)
        if name not in LOG_TOPICS and node not in hidden
    ]


class GraphFeed:
    """Builder of the graph message, with rates while a page shows it; for the web thread.

    :param name: name of the scope's node, which is left out
    :param worker: runs calls that wait for nodes
    :param send: sends the graph to the pages that show it
    """

    def __init__(self, name: str, worker: Worker, send: Callable[[Dict[str, Any]], None]) -> None:
        self._name, self._worker, self._send = name, worker, send
        self._queries = NodeQueries(name)
        self._rates = Rates()
        self._state: Optional[GraphState] = None

    def message(self) -> Optional[Dict[str, Any]]:
        """Return the graph; None until it is known."""
        return graph_message(self._state, self._rates, self._name) if self._state else None

    def on_state(self, state: GraphState, is_shown: bool) -> None:
        """Update the state of the graph.

        :param state: snapshot of the master
        :param is_shown: whether a page shows it
        """
        self._state = state
        if is_shown:
            nodes = {node for _, names in state.publishers for node in names} - {self._name}
            self._worker.run("counts", lambda: self._queries.message_counts(nodes), self._on_counts)
        else:
            self._rates = Rates()

    def _on_counts(self, answers: Any) -> None:
        if not isinstance(answers, Exception):
            self._rates.keep(set(answers))
            for node, (when, statistics) in answers.items():
                self._rates.add_counts(node, statistics, when)
        graph = self.message()
        if graph is not None:
            self._send(graph)
