"""Managed nodes on the graph, as pages see them; nodes and threads are fakes."""

from types import SimpleNamespace
from typing import Any, Callable, Dict, List
from unittest import mock

import pytest
from test_parameter_sender import SlowWorker

from topic_scope.controls import managed_nodes
from topic_scope.controls.managed_nodes import AGAIN_S, ManagedNodes

SERVICES = ("get_state", "get_available_transitions", "change_state")


def services(*nodes: str) -> List[str]:
    return [f"{node}/{name}" for node in nodes for name in SERVICES]


class World:
    """Managed nodes, and a page."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 100.0
        self.states: Dict[str, str] = {"/a": "inactive", "/b": "active"}
        self.calls: List[str] = []
        self.succeeds = True
        self.worker, self.send = SlowWorker(), mock.Mock()
        self.answers: List[Dict[str, Any]] = []
        monkeypatch.setattr(managed_nodes, "call_service", self.call)
        monkeypatch.setattr(managed_nodes, "time", SimpleNamespace(monotonic=lambda: self.now))
        self.nodes = ManagedNodes(self.worker, self.send)

    def call(self, service: str, _type: Any, *request: Any, **_: Any) -> Any:
        node, _, name = service.rpartition("/")
        self.calls.append(service)
        if node not in self.states:
            raise TimeoutError("no answer")
        if name == "get_state":
            reply: Any = SimpleNamespace(current_state=SimpleNamespace(label=self.states[node]))
        elif name == "change_state":
            reply = SimpleNamespace(success=self.succeeds)
            if self.succeeds:
                self.states[node] = request[0].label + "d"
        else:
            label = SimpleNamespace(transition=SimpleNamespace(label="activate"))
            reply = SimpleNamespace(available_transitions=[label])
        return SimpleNamespace(result=lambda: reply)

    def look(self, *nodes: str) -> None:
        self.nodes.on_services(services(*nodes))
        self.work()

    def work(self) -> None:
        while self.worker.work:
            self.worker.work.pop(0)()

    def shown(self) -> Dict[str, str]:
        return {one["node"]: one["state"] for one in self.nodes.message()["nodes"]}

    def change(self, node: str, label: str) -> None:
        self.nodes.change(node, label, self.answers.append)


@pytest.fixture
def world(monkeypatch: "pytest.MonkeyPatch") -> World:
    return World(monkeypatch)


def test_nodes_with_all_services_are_shown_until_they_are_gone(world: World) -> None:
    world.nodes.on_services([*services("/b", "/a"), "/c/get_state", "/c/change_state"])
    world.work()
    nodes = [
        {"node": node, "state": state, "transitions": ["activate"]}
        for node, state in (("/a", "inactive"), ("/b", "active"))
    ]
    assert world.nodes.message() == {"type": "managed", "nodes": nodes}
    assert not [call for call in world.calls if call.startswith("/c")]
    world.send.reset_mock()
    world.look("/b")
    world.send.assert_called_once_with({"type": "managed", "nodes": nodes[1:]})


def test_node_is_polled_in_its_period_and_sent_when_it_changes(world: World) -> None:
    world.look("/a")
    count = len(world.calls)
    world.look("/a")
    assert len(world.calls) == count
    world.send.reset_mock()
    world.now += AGAIN_S
    world.look("/a")
    assert len(world.calls) == 2 * count and not world.send.called
    world.states["/a"] = "finalized"
    world.now += AGAIN_S
    world.look("/a")
    assert world.send.call_count == 1 and world.shown() == {"/a": "finalized"}
    world.look()
    world.look("/a")  # a new node of this name: at once
    assert world.shown() == {"/a": "finalized"}


def test_silent_node_is_named_only_if_it_has_answered_before(world: World) -> None:
    world.look("/a", "/dead")
    assert world.shown() == {"/a": "inactive"}
    del world.states["/a"]
    world.now += AGAIN_S
    world.look("/a", "/dead")
    silent = {"node": "/a", "state": "does not answer", "transitions": []}
    assert world.nodes.message()["nodes"] == [silent]


def test_reply_of_a_node_that_has_gone_is_dropped(world: World) -> None:
    world.nodes.on_services(services("/a"))
    world.nodes.on_services([])
    world.work()
    assert world.shown() == {}


def test_transition_is_requested_once_and_its_state_is_shown_at_once(world: World) -> None:
    world.look("/a")
    with pytest.raises(ValueError, match="/a cannot fly now"):
        world.change("/a", "fly")
    world.change("/a", "activate")
    with pytest.raises(ValueError, match="/a has not finished an earlier request yet"):
        world.change("/a", "activate")
    world.work()
    assert world.shown() == {"/a": "activated"} and world.answers == []


@pytest.mark.parametrize(
    "fail, text",
    [
        (lambda world: setattr(world, "succeeds", False), "/a did not activate; see its log"),
        (lambda world: world.states.clear(), "/a did not activate: no answer"),
    ],
)
def test_failed_transition_is_reported(
    world: World, fail: Callable[[World], None], text: str
) -> None:
    world.look("/a")
    fail(world)
    world.change("/a", "activate")
    world.work()
    assert world.answers == [{"type": "error", "text": text}]
