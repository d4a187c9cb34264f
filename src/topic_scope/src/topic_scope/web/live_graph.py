"""Data source of a live ROS graph, with parameters, services and robots."""

from typing import Any, Callable, Dict, List

import tornado.ioloop

from nodekit import NodeScope
from topic_scope.controls.panel_manager import PanelManager
from topic_scope.graph.graph_feed import GraphFeed
from topic_scope.graph.worker import Worker
from topic_scope.graph.master_watch import GraphState, MasterWatch
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.open_page import Page
from topic_scope.protocol import requests
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.raw_subscriptions import RawSubscriptions, SteadyClock
from topic_scope.robots.live_scene import LiveScene
from topic_scope.web.data_source import Pages
from topic_scope.web.http_server import master_message


class LiveGraph:
    """Data source of a live ROS graph.

    :param node: node of the scope
    :param is_readonly: whether pages must not change anything
    """

    def __init__(self, node: NodeScope, is_readonly: bool) -> None:
        self.source = RawSubscriptions(SteadyClock())
        self.begin = self.source.clock.now()
        self.layouts = Layouts()
        self._node, self._is_readonly = node, is_readonly
        self._watch = MasterWatch(self.source, self.layouts)
        self.read_again = None
        self._trouble = ""  # problem of the master, as text

    def start(self, server: Pages) -> None:
        """Start polling the graph."""
        deliver: Callable[..., None] = tornado.ioloop.IOLoop.current().add_callback
        self._server = server
        self._controls = PanelManager(deliver, server.send_to_pages)
        self._graph = GraphFeed(self._node.name, Worker(deliver), self._send_graph)
        self._robots = LiveScene(self._node, deliver)
        self._watch.start(
            lambda state: deliver(self._on_state, state),
            lambda uri: deliver(self._on_silence, uri),
        )

    def _on_silence(self, uri: str) -> None:
        self._set_trouble(
            f"The ROS master at {uri} does not answer: traces continue, but nothing new is found."
        )

    def _set_trouble(self, text: str) -> None:
        if text != self._trouble:
            self._trouble = text
            for page in self._server.pages():
                page.put(master_message(text))

    def _on_state(self, state: GraphState) -> None:
        self._set_trouble("")
        self._server.on_topics(state.published_types)
        self._controls.on_state(state)
        self._graph.on_state(state, any(page.wants_graph for page in self._server.pages()))
        self._robots.on_state(state)

    def refresh(self) -> None:
        """Poll the graph immediately."""
        self._watch.refresh()

    # --- Pages -------------------------------------------------------------------------------

    def hello(self) -> Dict[str, Any]:
        """Return the fields that this source adds to a page's hello message."""
        return {"readonly": self._is_readonly}

    def messages(self) -> List[Dict[str, Any]]:
        """Return the messages for a new page."""
        return self._controls.messages() + [master_message(self._trouble)]

    def leave(self, page: Page) -> None:
        """Remove a page; a robot that it drove stops."""
        self._robots.leave(page)

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers of requests that show the graph and robots, or change something."""
        controls, robots = self._controls, self._robots
        return {
            "graph": Handler(requests.graph_of, self._show_graph),
            "robots": Handler(requests.robots_of, self._show_robots),
            "set": self._changing(
                requests.set_of,
                lambda page, wanted: controls.set(
                    wanted.node, wanted.name, wanted.value, page.put_once
                ),
            ),
            "call": self._changing(
                requests.call_of,
                lambda page, wanted: controls.call(wanted.service, wanted.data, page.put_once),
            ),
            "transition": self._changing(
                requests.transition_of,
                lambda page, wanted: controls.change_state(
                    wanted.node, wanted.label, page.put_once
                ),
            ),
            "steer": self._changing(requests.steering_of, robots.driving.steer),
            "drive": self._changing(requests.drive_of, robots.driving.drive),
            "goal": self._changing(requests.goal_of, robots.driving.send),
        }

    def _changing(
        self, check: Callable[[Dict[str, Any]], Any], change: Callable[[Page, Any], None]
    ) -> Handler:
        """Return a handler that rejects its requests on a read-only scope.

        :param check: as for :class:`.Handler`
        :param change: executes the request; raises ValueError if that is impossible
        """

        def handle(page: Page, wanted: Any) -> None:
            if self._is_readonly:
                raise RequestError("this scope is open to the network, and so is read-only")
            try:
                change(page, wanted)
            except ValueError as error:
                raise RequestError(str(error)) from None

        return Handler(check, handle)

    def _show_graph(self, page: Page, is_on: bool) -> None:
        page.wants_graph = is_on
        graph = self._graph.message()
        if is_on and graph is not None:
            page.put(graph)
            self._watch.refresh()

    def _show_robots(self, page: Page, is_on: bool) -> None:
        self._robots.show(page, is_on)
        self._watch.refresh()

    def _send_graph(self, message: Dict[str, Any]) -> None:
        for page in self._server.pages():
            if page.wants_graph:
                page.put(message)
