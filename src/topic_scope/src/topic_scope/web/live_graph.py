"""The graph of a master as what a scope shows, with parameters, services and robots."""

from typing import Any, Callable, Dict, List

import rospy
import tornado.ioloop

from topic_scope.controls.controls import Controls
from topic_scope.graph.background import Background
from topic_scope.graph.graph_feed import GraphFeed
from topic_scope.graph.master_watch import GraphState, MasterWatch
from topic_scope.messages.layouts import Layouts
from topic_scope.page.page import Page
from topic_scope.protocol import protocol
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.robot_requests import Drive, Goal, Robots, Steer
from topic_scope.record.raw_subscriptions import RawSubscriptions, SteadyClock
from topic_scope.robots.live_robots import LiveRobots
from topic_scope.web.origin import Host
from topic_scope.web.waiting import master_message


class LiveGraph:
    """What there is on the graph.

    :param is_readonly: whether pages may change nothing
    """

    def __init__(self, is_readonly: bool) -> None:
        self.source = RawSubscriptions(SteadyClock())
        self.layouts = Layouts()
        self._is_readonly = is_readonly
        self._watch = MasterWatch(self.source, self.layouts)
        self._trouble = ""  # what is wrong with the master, in words

    def start(self, host: Host) -> None:
        """Begin to follow the graph."""
        deliver: Callable[..., None] = tornado.ioloop.IOLoop.current().add_callback
        self._host = host
        self._controls = Controls(deliver, host.send_to_pages)
        self._graph = GraphFeed(rospy.get_name(), Background(deliver), self._tell_graph)
        self._robots = LiveRobots(rospy.get_name(), deliver)
        self._watch.start(
            lambda state: deliver(self._on_state, state),
            lambda uri: deliver(self._on_silence, uri),
        )

    def _on_silence(self, uri: str) -> None:
        self._set_trouble(
            f"The ROS master at {uri} does not answer: traces go on, and nothing new is seen."
        )

    def _set_trouble(self, text: str) -> None:
        if text != self._trouble:
            self._trouble = text
            for page in self._host.pages():
                page.put(master_message(text))

    def _on_state(self, state: GraphState) -> None:
        self._set_trouble("")
        self._host.on_topics(state.published_types)
        self._controls.on_state(state)
        self._graph.on_state(state, any(page.wants_graph for page in self._host.pages()))
        self._robots.on_state(state)

    def ring(self) -> None:
        """Look at the graph at once."""
        self._watch.ring()

    # --- Pages -------------------------------------------------------------------------------

    def hello(self) -> Dict[str, Any]:
        """Return what the greeting of a page has besides."""
        return {"readonly": self._is_readonly}

    def messages(self) -> List[Dict[str, Any]]:
        """Return what a new page is told."""
        return self._controls.messages() + [master_message(self._trouble)]

    def leave(self, page: Page) -> None:
        """Forget a page; a robot that it drove stops."""
        self._robots.leave(page)

    def handle(self, page: Page, request: protocol.Request) -> None:
        """Show the graph or robots, or change something on the graph.

        :raises RequestError: if that cannot be done
        """
        if isinstance(request, protocol.Graph):
            page.wants_graph = request.on
            graph = self._graph.message()
            if request.on and graph is not None:
                page.put(graph)
                self._watch.ring()
        elif isinstance(request, Robots):
            self._robots.handle(page, request)
            self._watch.ring()
        else:
            self._control(page, request)

    def _control(self, page: Page, request: protocol.Request) -> None:
        if self._is_readonly:
            raise RequestError("this scope is open to the network, and so is read-only")
        try:
            if isinstance(request, (Steer, Drive, Goal)):
                self._robots.control(page, request)
            else:
                self._controls.obey(request, page.put_once)
        except ValueError as error:
            raise RequestError(str(error)) from None

    def _tell_graph(self, message: Dict[str, Any]) -> None:
        for page in self._host.pages():
            if page.wants_graph:
                page.put(message)
