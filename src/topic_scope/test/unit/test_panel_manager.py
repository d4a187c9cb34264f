"""Panels of nodes that end and start again; master, services and threads are fakes."""

from typing import Any, Dict, List, Mapping
from unittest import mock

import pytest
from test_parameter_sender import NODE, Gauge, SlowWorker

from nodekit import ChangeRefused, ParameterError, describe
from nodekit.testing.offline_parameters import OfflineParameters
from topic_scope.controls import panel_manager


class Graph:
    """Graph on which one node starts and ends."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.worker = SlowWorker()
        self.answers: List[Dict[str, Any]] = []
        client = mock.Mock()
        client.describe = lambda: {one["name"]: one for one in describe(self.node.values)}
        client.change = self.change
        monkeypatch.setattr("tornado.ioloop.PeriodicCallback", mock.Mock())
        monkeypatch.setattr(panel_manager, "Worker", lambda _deliver: self.worker)
        monkeypatch.setattr(panel_manager, "ParameterClient", lambda _node: client)
        monkeypatch.setattr(panel_manager, "follow_parameter", mock.Mock())
        self.manager = panel_manager.PanelManager(lambda function: function(), mock.Mock())

    def start(self) -> None:
        self.node = OfflineParameters(Gauge)
        self.manager.on_services([f"{NODE}/describe", f"{NODE}/change"])
        self.work()

    def end(self) -> None:
        self.manager.on_services([])
        self.work()

    def change(self, values: Mapping[str, Any]) -> Dict[str, Any]:
        try:
            self.node.change(values)
        except ParameterError as error:
            raise ChangeRefused(str(error)) from None
        return dict(self.node.server)

    def set(self, name: str, value: Any) -> None:
        self.manager.set(NODE, name, value, self.answers.append)
        self.work()

    def work(self) -> None:
        while self.worker.work:
            self.worker.work.pop(0)()


def test_restarted_node_does_not_get_a_value_that_it_rejected_before(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    graph = Graph(monkeypatch)
    graph.start()
    graph.set("low", 50)
    assert graph.answers[0]["type"] == "refused"
    graph.end()
    graph.start()
    graph.set("high", 60)
    assert (graph.node.values.low, graph.node.values.high) == (0.0, 60.0)
