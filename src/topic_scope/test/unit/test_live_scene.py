"""Robots of a live graph on pages that come and go, without a master."""

from typing import Any, List
from unittest import mock

import pytest
from test_parameter_sender import SlowWorker

from topic_scope.graph.master_watch import GraphState
from topic_scope.page.open_page import Page
from topic_scope.robots import live_scene

ODOMETRY = "nav_msgs/Odometry"
STATE = GraphState(
    [("/odom", ["/robot"]), ("/own", ["/scope"]), ("/gone", [])],
    [],
    [],
    {"/odom": ODOMETRY, "/own": ODOMETRY, "/gone": ODOMETRY},
)


@pytest.fixture
def scene(monkeypatch: "pytest.MonkeyPatch") -> Any:
    worker, driving, subscriptions = SlowWorker(), mock.Mock(), mock.Mock()
    driving.targets.return_value = {"type": "targets"}
    monkeypatch.setattr("tornado.ioloop.PeriodicCallback", mock.Mock())
    monkeypatch.setattr(live_scene, "Worker", lambda _deliver: worker)
    monkeypatch.setattr(live_scene, "Driving", lambda *_: driving)
    monkeypatch.setattr(live_scene, "RawSubscriptions", lambda _clock: subscriptions)
    node = mock.Mock()
    node.name = "/scope"
    made: Any = live_scene.LiveScene(node, mock.Mock())
    made.worker, made.subscriptions = worker, subscriptions
    return made


def wanted(scene: Any) -> List[str]:
    return list(scene.subscriptions.want.call_args[0][0])


def test_robots_of_other_nodes_are_received_while_a_page_shows_them(scene: Any) -> None:
    page = Page(5.0)
    scene.on_state(STATE)
    assert wanted(scene) == []
    scene.show(page, True)  # at once, not at the next look at the master
    assert wanted(scene) == ["/odom"]
    assert {"type": "targets"} in page.pop_messages()
    scene.worker.work.pop()()
    scene.subscriptions.adjust.assert_called_once_with()
    scene.driving.rest.reset_mock()
    scene.on_state(STATE)
    scene.driving.rest.assert_not_called()
    scene.show(page, False)
    scene.driving.leave.assert_called_once_with(page)  # a robot that it drove stops
    scene.on_state(STATE)
    assert wanted(scene) == []
    scene.driving.rest.assert_called_once_with()
