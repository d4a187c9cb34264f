"""Keeps the pages that show robots up to date, and does what they ask of robots."""

from typing import Any, Callable, Dict, Mapping, Optional, Set, Tuple, Union

import rospy
import tornado.ioloop

from topic_scope import scene
from topic_scope.background import Background
from topic_scope.driving import Driving
from topic_scope.layouts import Layouts
from topic_scope.master_watch import GraphState
from topic_scope.page import Page
from topic_scope.robot_requests import Drive, Goal, Robots, Steer
from topic_scope.taps import Batch, Clock, Taps
from topic_scope.whole import WholeReader

#: Time between two looks at what has come, s; and how many go by till things that stand are told.
_PERIOD_S, _SLOWLY = 0.05, 5
_LOG_PERIOD_S = 60.0


class RobotView:
    """Makes the robot view; topics are subscribed to only while a page shows it.

    All methods belong to the thread of the web.

    :param name: name of the scope's node
    :param deliver: hands a function to that thread
    """

    def __init__(self, name: str, deliver: Callable[[Callable[[], None]], None]) -> None:
        self._name = name
        self._background = Background(deliver)
        self._driving = Driving(name, self._background)
        self._clock = Clock()
        self._taps = Taps(self._clock)
        self._layouts = Layouts()
        self._readers: Dict[Tuple[str, str], Optional[WholeReader]] = {}
        self._scene = scene.Scene()
        self._topics: Mapping[str, str] = {}
        self._state: Optional[GraphState] = None
        self._pages: Set[Page] = set()
        self._told: Dict[str, Dict[str, Any]] = {}
        self._ticks = 0
        tornado.ioloop.PeriodicCallback(self._tick, _PERIOD_S * 1e3).start()

    # --- From the graph ----------------------------------------------------------------------

    def on_state(self, state: GraphState) -> None:
        """Take note of what is on the graph."""
        self._state = state
        self._driving.on_state(state)
        if self._pages:
            others = {topic for topic, nodes in state.publishers if set(nodes) - {self._name}}
            types = state.published_types
            self._topics = {
                topic: types[topic] for topic in others & set(types) if self._is_shown(types[topic])
            }
            self._scene.keep(self._topics)
            self._tell(self._driving.targets())
        else:
            self._topics = {}
            self._driving.rest()
        self._taps.want(list(self._topics))
        if set(self._topics) != set(self._taps.open()):
            self._background.run("taps", self._taps.adjust, lambda _: None)

    def _is_shown(self, datatype: str) -> bool:
        if datatype in scene.TYPES or datatype.endswith("/RobotStatus"):
            return True
        return scene.is_status(self._layouts.installed(datatype))

    def _tick(self) -> None:
        if not self._pages:
            return
        now = self._clock.now()
        for topic, tap in self._taps.open().items():
            for batch in tap.take():
                self._take(topic, batch, now)
        self._tell(self._scene.moving(now))
        self._ticks += 1
        if self._ticks % _SLOWLY == 0:
            self._tell(self._scene.standing())
            self._tell(self._scene.fleet(now))

    def _take(self, topic: str, batch: Batch, now: float) -> None:
        reader = self._reader(batch.header)
        datatype = batch.header.get("type", "")
        if reader is None or topic not in self._topics or not self._is_known(batch.header):
            return
        messages = batch.messages if datatype in scene.CUMULATIVE else batch.messages[-1:]
        for data in messages:
            try:
                self._scene.take(topic, datatype, reader.read(data), now)
            except (LookupError, TypeError, ValueError) as error:
                text = (
                    f"{topic} is left out of the robot view: {datatype} is not as known: {error!r}"
                )
                rospy.logwarn_throttle(_LOG_PERIOD_S, text)

    def _is_known(self, header: Mapping[str, str]) -> bool:
        return header["type"] in scene.TYPES or scene.is_status(self._layouts.received(header))

    def _reader(self, header: Mapping[str, str]) -> Optional[WholeReader]:
        key = (header.get("type", ""), header.get("md5sum", ""))
        if key not in self._readers:
            layout = self._layouts.received(header)
            self._readers[key] = WholeReader(layout) if layout is not None else None
        return self._readers[key]

    # --- Pages -------------------------------------------------------------------------------

    def _tell(self, message: Dict[str, Any]) -> None:
        """Tell all pages that show robots, if there is anything new to tell."""
        if self._told.get(message["type"]) != message:
            self._told[message["type"]] = message
            for page in self._pages:
                page.put(message)

    def handle(self, page: Page, request: Robots) -> None:
        """Begin or end to show robots on a page."""
        if not request.on:
            self.leave(page)
            return
        self._pages.add(page)
        for message in self._told.values():
            page.put(message)
        if self._state is not None:
            self.on_state(self._state)

    def control(self, page: Page, request: Union[Steer, Drive, Goal]) -> None:
        """Drive a robot, or send it to a place.

        :raises ValueError: if that cannot be done
        """
        if isinstance(request, Steer):
            self._driving.steer(page, request)
        elif isinstance(request, Drive):
            self._driving.drive(page, request)
        else:
            self._driving.send(page, request)

    def leave(self, page: Page) -> None:
        """Forget a page; a robot that it drove stops."""
        self._driving.leave(page)
        self._pages.discard(page)
