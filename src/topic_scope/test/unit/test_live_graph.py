"""Messages about a live graph to its pages, without a master."""

from typing import Any, Dict, List
from unittest import mock

import pytest

from topic_scope.graph.master_watch import GraphState
from topic_scope.page.open_page import Page
from topic_scope.protocol.checks import RequestError
from topic_scope.web import live_graph
from topic_scope.web.live_graph import LiveGraph

SILENT = "The ROS master at http://m:1 does not answer: traces continue, but nothing new is found."


class World:
    """Live graph with two pages; its parts are fakes."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch", is_readonly: bool = False) -> None:
        self.parts: Dict[str, mock.Mock] = {}
        for name in ("PanelManager", "GraphFeed", "LiveScene", "MasterWatch", "RawSubscriptions"):
            self.parts[name] = mock.Mock()
            monkeypatch.setattr(live_graph, name, mock.Mock(return_value=self.parts[name]))
        loop = mock.Mock(add_callback=lambda function, *arguments: function(*arguments))
        monkeypatch.setattr("tornado.ioloop.IOLoop.current", lambda: loop)
        self.pages = [Page(5.0), Page(5.0)]
        self.session = mock.Mock(**{"pages.return_value": self.pages})
        self.graph = LiveGraph(mock.Mock(), is_readonly)
        self.graph.start(self.session)
        self.on_state, self.on_silence = self.parts["MasterWatch"].start.call_args[0]
        self.send_graph = live_graph.GraphFeed.call_args[0][2]  # type: ignore[attr-defined]

    def texts(self) -> List[List[str]]:
        return [
            [one["text"] for one in page.pop_messages() if one["type"] == "master"]
            for page in self.pages
        ]

    def request(self, kind: str, request: Any) -> None:
        handler = self.graph.handlers()[kind]
        handler.handle(self.pages[0], handler.check(request))


def test_silence_of_the_master_and_its_end_are_reported_once(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    world = World(monkeypatch)
    for said in ([SILENT], []):
        world.on_silence("http://m:1")
        assert world.texts() == [said] * 2
    world.parts["PanelManager"].messages.return_value = []
    assert world.graph.messages()[-1]["text"] == SILENT
    for said in ([""], []):
        world.on_state(GraphState([], [], [], {}))
        assert world.texts() == [said] * 2


def test_graph_is_sent_to_the_pages_that_show_it(monkeypatch: "pytest.MonkeyPatch") -> None:
    world = World(monkeypatch)
    feed, state = world.parts["GraphFeed"], GraphState([("/a", ["/b"])], [], [], {})
    feed.message.return_value = {"type": "graph"}
    world.on_state(state)
    feed.on_state.assert_called_once_with(state, False)
    world.session.on_topics.assert_called_once_with({"/a": "*"})
    world.request("graph", {"on": True})
    world.parts["MasterWatch"].refresh.assert_called_once_with()
    world.send_graph({"type": "graph", "nodes": []})
    assert [page.pop_messages() for page in world.pages] == [[{"type": "graph", "nodes": []}], []]
    world.on_state(state)
    assert feed.on_state.call_args == mock.call(state, True)
    world.request("graph", {"on": False})
    world.send_graph({"type": "graph", "nodes": []})
    assert world.pages[0].pop_messages() == []


def test_read_only_scope_changes_nothing(monkeypatch: "pytest.MonkeyPatch") -> None:
    requests: Dict[str, Dict[str, Any]] = {
        "set": {"node": "/a", "name": "x", "value": 1},
        "call": {"service": "/a/home"},
        "transition": {"node": "/a", "label": "activate"},
        "steer": {"topic": "/cmd_vel"},
        "drive": {"speed": 1.0, "turn": 0.0, "sent": 1.0},
        "goal": {"topic": "/goal", "frame": "map", "x": 0.0, "y": 0.0, "heading": 0.0},
    }
    world = World(monkeypatch, is_readonly=True)
    controls, driving = world.parts["PanelManager"], world.parts["LiveScene"].driving
    doers = controls.set, controls.call, controls.change_state
    doers += driving.steer, driving.drive, driving.send
    for kind, request in requests.items():
        with pytest.raises(RequestError, match="read-only"):
            world.request(kind, request)
    assert not any(doer.called for doer in doers) and world.graph.hello() == {"readonly": True}
    world = World(monkeypatch)
    controls, driving = world.parts["PanelManager"], world.parts["LiveScene"].driving
    doers = controls.set, controls.call, controls.change_state
    doers += driving.steer, driving.drive, driving.send
    for (kind, request), doer in zip(requests.items(), doers):
        doer.side_effect = ValueError("no such thing")
        with pytest.raises(RequestError, match="no such thing"):
            world.request(kind, request)
    assert controls.set.call_args[0][:3] == ("/a", "x", 1)
