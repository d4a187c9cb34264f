"""Robots of a live graph, shown and driven by pages."""

from typing import Callable, Optional

import tornado.ioloop

from nodekit import NodeScope
from topic_scope.graph.worker import Worker
from topic_scope.graph.master_watch import GraphState
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.open_page import Page
from topic_scope.sampling.raw_subscriptions import RawSubscriptions, SteadyClock
from topic_scope.robots import scene_feed
from topic_scope.robots.driving import Driving


class LiveScene:
    """Robot view and driving; topics are subscribed to only while a page shows them.

    All methods are for the web thread.

    :param node: node of the scope
    :param deliver: runs a function in the web thread

    :ivar driving: driving of robots
    """

    def __init__(self, node: NodeScope, deliver: Callable[[Callable[[], None]], None]) -> None:
        self._name = node.name
        self._worker = Worker(deliver)
        self.driving = Driving(node, self._worker)
        self._subscriptions = RawSubscriptions(SteadyClock())
        self._view = scene_feed.SceneFeed(self._subscriptions, Layouts())
        self._state: Optional[GraphState] = None
        tornado.ioloop.PeriodicCallback(self._view.update, scene_feed.PERIOD_S * 1e3).start()

    def on_state(self, state: GraphState) -> None:
        """Update the state of the graph."""
        self._state = state
        self.driving.on_state(state)
        others = {topic for topic, nodes in state.publishers if set(nodes) - {self._name}}
        types = state.published_types
        self._view.set_topics({topic: types[topic] for topic in others & set(types)})
        if self._view.pages:
            self._view.send_to_pages(self.driving.targets())
        else:
            self.driving.rest()
        if self._subscriptions.is_to_adjust:
            self._worker.run("subscriptions", self._subscriptions.adjust, lambda _: None)

    def show(self, page: Page, is_on: bool) -> None:
        """Start or stop showing robots on a page."""
        if not is_on:
            self.leave(page)
            return
        self._view.enter(page)
        if self._state is not None:
            self.on_state(self._state)

    def leave(self, page: Page) -> None:
        """Remove a page; a robot that it drove stops."""
        self.driving.leave(page)
        self._view.leave(page)
