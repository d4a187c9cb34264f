"""Panels of nodes that end and start again; master, services and threads are fakes."""

from types import SimpleNamespace
from typing import Any, Callable, Dict, List, Mapping
from unittest import mock

import pytest
from test_parameter_sender import NODE, Gauge, SlowWorker

from nodekit import ChangeRefused, DescriptionError, ParameterError, describe
from nodekit.testing.offline_parameters import OfflineParameters
from topic_scope.controls import panel_manager, service_buttons
from topic_scope.graph.master_watch import GraphState


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
        self.followed = mock.Mock()
        monkeypatch.setattr(panel_manager, "follow_parameter", self.follow)
        self.now, self.send = 100.0, mock.Mock()
        monkeypatch.setattr(panel_manager, "time", SimpleNamespace(monotonic=lambda: self.now))
        monkeypatch.setattr(service_buttons, "kind_of", self.kind_of)
        self.asked: List[str] = []
        self.manager = panel_manager.PanelManager(lambda function: function(), self.send)

    def follow(self, key: str, callback: Callable[[Any], None]) -> mock.Mock:
        assert key == NODE
        self.report = callback
        return self.followed

    def kind_of(self, service: str) -> str:
        self.asked.append(service)
        return "Trigger" if service.endswith("/home") else ""

    def services(self, *names: str) -> List[str]:
        return [f"{NODE}/describe", f"{NODE}/change", *names]

    def panels(self) -> List[Dict[str, Any]]:
        """Return the panels that were last sent."""
        sent = [call[0][0] for call in self.send.call_args_list]
        return next(one["panels"] for one in reversed(sent) if one["type"] == "panels")

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


def test_panel_has_the_buttons_of_its_node_and_disappears_with_it(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    graph = Graph(monkeypatch)
    graph.start()
    graph.end()
    graph.followed.reset_mock()
    services = graph.services(f"{NODE}/home", f"{NODE}/other", f"{NODE}s/home", "/far/home")
    graph.manager.on_services(services)
    graph.work()
    assert graph.asked == [f"{NODE}/home", f"{NODE}/other"]  # each costs a call
    (panel,) = graph.panels()
    assert panel["services"] == [{"name": f"{NODE}/home", "kind": "Trigger"}]
    graph.followed.report_again.assert_called_once_with()  # it may have changed meanwhile
    kinds = [message["type"] for message in graph.manager.messages()]
    assert kinds == ["panels", "managed", "statuses"]
    # The master lists a service without a node for a moment.
    gone = GraphState([], [], [(name, []) for name in services], {})
    graph.manager.on_state(gone)
    graph.work()
    assert graph.panels() == []
    graph.followed.close.assert_called_once_with()


def test_node_that_cannot_be_described_is_asked_again_later(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    graph = Graph(monkeypatch)
    graph.node = OfflineParameters(Gauge)
    calls: List[str] = []

    def fail(node: str) -> Any:
        calls.append(node)
        raise DescriptionError("no answer")

    with monkeypatch.context() as patched:
        patched.setattr(graph.manager, "_describe", fail)
        for _ in range(2):
            graph.manager.on_services(graph.services())
            graph.work()
        graph.followed.close.assert_called_once_with()
        graph.now += panel_manager.RETRY_S + 0.1
        graph.manager.on_services(graph.services())
        graph.work()
        assert calls == [NODE, NODE]
    graph.manager.on_services([])
    graph.manager.on_services(graph.services())  # a new node of this name: at once
    graph.work()
    assert [one["node"] for one in graph.panels()] == [NODE]


def test_node_with_both_descriptions_has_one_panel(monkeypatch: "pytest.MonkeyPatch") -> None:
    graph = Graph(monkeypatch)
    graph.node = OfflineParameters(Gauge)
    graph.manager.on_services(graph.services(f"{NODE}/set_parameters"))
    assert len(graph.worker.work) == 1
    graph.work()
    graph.set("low", 5)  # by its own service
    assert graph.node.values.low == 5.0
