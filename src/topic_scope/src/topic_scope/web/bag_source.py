"""Data source that plays a bag by the bag's clock."""

import os
from typing import Any, Dict, List

import rospy
import tornado.ioloop

from topic_scope.bag.message_at import MessageFinder
from topic_scope.bag.opening import learn_types, open_bag
from topic_scope.bag.player import BagPlayer
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.open_page import Page
from topic_scope.protocol import requests
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.requests import Handler
from topic_scope.robots.scene_feed import PERIOD_S, SceneFeed
from topic_scope.web.data_source import Pages

#: Period of progress updates [s].
_PERIOD_S = 0.025


class BagSource:
    """Data source of a bag; it has no nodes, hence no graph and no parameters.

    Robots are shown by the clock of the bag.

    :param path: the file
    :param history: history before the clock to show [s]
    :param window: initial time span [s], at whose end the clock starts
    :raises BagError: if it cannot be read, or has no messages
    """

    def __init__(self, path: str, history: float, window: float) -> None:
        self._name = os.path.basename(path)
        bag = open_bag(path)
        self.source = BagPlayer(bag, history)
        self.begin = self.source.start
        self.read_again = MessageFinder(path).find
        self.layouts = Layouts()
        self._robots = SceneFeed(self.source.aside, self.layouts)
        self._window = window
        self._types = learn_types(bag, self.layouts)
        for topic, problem in bag.faults.items():
            rospy.logwarn(f"{path}: {topic} is left out: {problem}")
        self._jumps = 0
        self._told: Dict[str, Any] = {}

    def start(self, server: Pages) -> None:
        """Show the first window of the bag, paused."""
        self._server = server
        server.on_topics(self._types)
        self._seek(self.source.start + self._window)
        tornado.ioloop.PeriodicCallback(self._update, _PERIOD_S * 1e3).start()
        tornado.ioloop.PeriodicCallback(self._update_robots, PERIOD_S * 1e3).start()

    def refresh(self) -> None:
        """Read the shown span again if fields were added."""
        if self.source.lacks_past:
            self._seek(self.source.place)

    def _seek(self, time: float) -> None:
        self.source.seek(time)
        self._server.halt()
        self._robots.forget()
        self._is_loading = True

    def _jump(self, time: float) -> None:
        self._jumps += 1
        self._seek(time)

    def _update_robots(self) -> None:
        if not self.source.is_loading:
            self._robots.update()

    def _update(self) -> None:
        """Send the state of the playback to all pages."""
        if self._is_loading and not self.source.is_loading:
            self._is_loading = False
            self._server.resume()
            self._server.on_topics(self._types)  # messages may contain new names of elements
            self.refresh()
        while self.source.problems:
            text = self.source.problems.popleft()
            rospy.logwarn(text)
            for page in self._server.pages():
                page.put_once({"type": "error", "text": text})
        if self._state() != self._told:
            self._told = self._state()
            self._server.send_to_pages(self._told)

    def _state(self) -> Dict[str, Any]:
        return {
            "type": "playback",
            "playing": self.source.is_playing,
            "speed": self.source.speed,
            "loading": self.source.is_loading,
            "jumps": self._jumps,
        }

    # --- Pages -------------------------------------------------------------------------------

    def hello(self) -> Dict[str, Any]:
        """Return the fields that this source adds to a page's hello message."""
        ends = {"start": self.source.start, "end": self.source.end}
        return {"readonly": False, "bag": {"name": self._name, **ends}}

    def messages(self) -> List[Dict[str, Any]]:
        """Return the messages for a new page."""
        return [self._state()]

    def leave(self, page: Page) -> None:
        """Remove a page."""
        self._robots.leave(page)
        self._robots.set_topics(self._types)

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers of requests about robots and playback."""
        needs_nodes = ("graph", "set", "call", "transition", "steer", "drive", "goal")
        return {
            "robots": Handler(requests.robots_of, self._show_robots_on),
            "playback": Handler(requests.playback_of, self._play),
            **dict.fromkeys(needs_nodes, Handler(dict, _refuse)),
        }

    def _show_robots_on(self, page: Page, is_on: bool) -> None:
        show = self._robots.enter if is_on else self._robots.leave
        show(page)
        self._robots.set_topics(self._types)
        self.refresh()

    def _play(self, _page: Page, request: requests.Playback) -> None:
        if request.speed is not None:
            self.source.speed = request.speed
        if request.time is not None:
            self._jump(request.time)
        if request.playing is False:
            self.source.pause()
        elif request.playing and not self.source.is_playing:
            if self.source.place >= self.source.end:
                self._jump(self.source.start)
            self.source.play()


def _refuse(_page: Page, _request: Dict[str, Any]) -> None:
    raise RequestError("this is a bag: it has no nodes, so no graph and no parameters")
