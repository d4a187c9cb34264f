"""A bag as what a scope shows, with its clock in the place of the computer's."""

import os
from typing import Any, Dict, List

import rospy
import tornado.ioloop

from topic_scope.bag.bag_file import BagFile
from topic_scope.bag.bag_player import BagPlayer
from topic_scope.messages.layouts import Layouts
from topic_scope.page.page import Page
from topic_scope.protocol import protocol
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.playback import Playback
from topic_scope.protocol.robot_requests import Robots
from topic_scope.robots.robot_view import PERIOD_S, RobotView
from topic_scope.web.origin import Host

#: Time between two looks at how far it is, s.
_PERIOD_S = 0.025


class Recording:
    """What there is in a bag; there are no nodes, and so no graph and no parameters.

    Robots are shown by the clock of the bag, as they were then.

    :param path: the file
    :param history: how much of what came before the clock is shown, s
    :param window: span of time that is shown at first, s: where the clock begins
    :raises BagError: if it cannot be read, or holds nothing
    """

    def __init__(self, path: str, history: float, window: float) -> None:
        self._name = os.path.basename(path)
        bag = BagFile(path)
        self.source = BagPlayer(bag, history)
        self.layouts = Layouts()
        self._robots = RobotView(self.source.aside, self.layouts)
        self._window = window
        self._types: Dict[str, str] = {}
        for connection in bag.connections.values():
            # What the bag says of a type counts, whatever is installed under its name.
            self.layouts.received(connection.header)
            self._types.setdefault(connection.topic, connection.header.get("type", "*"))
        self._jumps = 0
        self._told: Dict[str, Any] = {}

    def start(self, host: Host) -> None:
        """Show the first window of the bag, and wait for somebody who wants it to go on."""
        self._host = host
        host.on_topics(self._types)
        self._seek(self.source.start + self._window)
        tornado.ioloop.PeriodicCallback(self._look, _PERIOD_S * 1e3).start()
        tornado.ioloop.PeriodicCallback(self._show_robots, PERIOD_S * 1e3).start()

    def ring(self) -> None:
        """Read again what is shown, where more is wanted of it."""
        if self.source.lacks_past:
            self._seek(self.source.place)

    def _seek(self, time: float) -> None:
        self.source.seek(time)
        self._host.halt()
        self._robots.forget()
        self._is_loading = True

    def _jump(self, time: float) -> None:
        self._jumps += 1
        self._seek(time)

    def _show_robots(self) -> None:
        if not self.source.is_loading:
            self._robots.update()

    def _look(self) -> None:
        """Tell pages how far it is."""
        if self._is_loading and not self.source.is_loading:
            self._is_loading = False
            self._host.resume()
            self._host.on_topics(self._types)  # messages may have told names of their elements
            self.ring()
        while self.source.problems:
            text = self.source.problems.popleft()
            rospy.logwarn(text)
            for page in self._host.pages():
                page.put_once({"type": "error", "text": text})
        if self._state() != self._told:
            self._told = self._state()
            self._host.send_to_pages(self._told)

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
        """Return what the greeting of a page has besides."""
        ends = {"begin": self.source.start, "end": self.source.end}
        return {"readonly": False, "bag": {"name": self._name, **ends}}

    def messages(self) -> List[Dict[str, Any]]:
        """Return what a new page is told."""
        return [self._state()]

    def leave(self, page: Page) -> None:
        """Forget a page."""
        self._robots.leave(page)
        self._robots.set_topics(self._types)

    def handle(self, page: Page, request: protocol.Request) -> None:
        """Show robots on a page; or, for all pages, play, stop, or go elsewhere.

        :raises RequestError: if something else is asked for
        """
        if isinstance(request, Robots):
            show = self._robots.enter if request.on else self._robots.leave
            show(page)
            self._robots.set_topics(self._types)
            self.ring()
        elif isinstance(request, Playback):
            self._play(request)
        else:
            raise RequestError("this is a bag: it has no nodes, so no graph and no parameters")

    def _play(self, request: Playback) -> None:
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
