"""Playback of a bag as pages see it."""

from pathlib import Path
from typing import Any, Callable, Dict, List
from unittest import mock

import pytest
from bags import BEGIN, write_bag
from std_msgs.msg import Float64

from topic_scope.bag.player import BagPlayer
from topic_scope.page.open_page import Page
from topic_scope.protocol.checks import RequestError
from topic_scope.web import bag_source
from topic_scope.web.bag_source import BagSource


class World:
    """Bag of 10 s, and a session that shows its first 5 s; the test sets the time."""

    def __init__(self, path: Path, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 50.0
        self.sent: List[Dict[str, Any]] = []
        periodic = mock.Mock()
        monkeypatch.setattr("tornado.ioloop.PeriodicCallback", periodic)
        monkeypatch.setattr(
            bag_source, "BagPlayer", lambda bag, history: BagPlayer(bag, history, self.time)
        )
        self.robots = mock.Mock()
        monkeypatch.setattr(bag_source, "SceneFeed", lambda *_: self.robots)
        messages = [("/a", Float64(float(n)), n * 10**8) for n in range(101)]
        self.source = BagSource(write_bag(path / "x.bag", messages), 60.0, 5.0)
        self.page = Page(5.0)
        self.session = mock.Mock(**{"pages.return_value": [self.page]})
        self.session.send_to_pages = self.sent.append
        self.source.start(self.session)
        self.update, self.update_robots = (call[0][0] for call in periodic.call_args_list)
        self.load()

    def time(self) -> float:
        return self.now

    def load(self) -> None:
        self.source.source.now()
        self.update()

    def go_on(self, seconds: float) -> float:
        """Let time pass; return the present time in the bag [s]."""
        self.now += seconds
        self.source.source.now()
        self.update()
        return round(self.source.source.place - BEGIN / 1e9, 3)

    def play(self, **request: Any) -> None:
        handler = self.source.handlers()["playback"]
        handler.handle(self.page, handler.check(request))


@pytest.fixture
def world(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> World:
    return World(tmp_path, monkeypatch)


def test_bag_plays_to_its_end_and_then_from_its_start(world: World) -> None:
    assert world.go_on(1.0) == 5.0
    world.play(playing=True, speed=2.0)
    assert world.go_on(1.0) == 7.0
    assert world.go_on(3.0) == 10.0 and world.sent[-1]["playing"] is False
    world.play(playing=True)
    world.load()
    assert world.go_on(1.0) == 2.0
    world.play(playing=False)
    assert world.go_on(1.0) == 2.0


def test_state_of_the_playback_is_sent_when_it_changes(world: World) -> None:
    state = {"type": "playback", "playing": False, "speed": 1.0, "loading": False, "jumps": 0}
    assert world.sent == [state] and world.source.messages() == [state]
    world.update()
    assert len(world.sent) == 1
    world.play(time=BEGIN / 1e9 + 1.0)
    world.update()
    world.load()
    assert world.sent[1:] == [{**state, "loading": True, "jumps": 1}, {**state, "jumps": 1}]


def test_jump_drops_samples_and_robots_until_it_is_loaded(world: World) -> None:
    world.session.reset_mock()
    world.robots.reset_mock()
    world.play(time=BEGIN / 1e9 + 1.0)
    world.session.halt.assert_called_once_with()
    world.robots.forget.assert_called_once_with()
    world.update_robots()
    assert not world.robots.update.called and not world.session.resume.called
    world.load()
    world.update_robots()
    world.robots.update.assert_called_once_with()
    world.session.resume.assert_called_once_with()


def test_problem_of_the_bag_is_reported_to_all_pages(world: World) -> None:
    world.source.source.problems.append("x.bag is damaged")
    with mock.patch("rospy.logwarn") as log:
        world.update()
    log.assert_called_once_with("x.bag is damaged")
    assert world.page.pop_messages() == [{"type": "error", "text": "x.bag is damaged"}]


def test_nodes_are_not_asked_of_a_bag(world: World) -> None:
    handle: Callable[..., None] = world.source.handlers()["set"].handle
    with pytest.raises(RequestError, match="this is a bag"):
        handle(world.page, {})
