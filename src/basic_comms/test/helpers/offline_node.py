"""Node without a master, for unit tests of node classes."""

import copy
from types import SimpleNamespace
from typing import Any, Callable, Dict, List

from nodekit import Names, Node, Subscription


class Published:
    """Fake publisher that keeps copies of the messages."""

    def __init__(self, name: str) -> None:
        self.resolved_name = name
        self.messages: List[Any] = []

    def publish(self, message: Any) -> None:
        self.publish_all([message])

    def publish_all(self, messages: List[Any]) -> None:
        self.messages += map(copy.copy, messages)


class OfflineNode(Node):
    """Fake node that keeps the callbacks of a node class, so that a test can call them by group.

    :param values: parameters that differ from their defaults
    """

    def __init__(self, **values: Any) -> None:
        super().__init__(Names("/node", True))
        self.settings = SimpleNamespace(values=None)
        #: Published messages by topic.
        self.published: Dict[str, List[Any]] = {}
        self.services: Dict[str, Callable[[Any], Any]] = {}
        self.tick: Callable[[float], None]
        #: Takes messages as from a connection: a list, and that it may be kept waiting.
        self.receive: Callable[[List[Any], bool], None]
        self._values = values

    def declare_parameters(self, declaration: Any, *_: Any, **__: Any) -> Any:
        self.settings.values = declaration(**self._values)
        return self.settings

    def create_publisher(self, name: str, *_: Any, **__: Any) -> Any:
        made = Published(name)
        self.published[name] = made.messages
        return made

    def create_service(self, name: str, _kind: type, handler: Any, *_: Any, **__: Any) -> Any:
        self.services[name] = handler

    def create_timer(self, _rate: Any, callback: Any, *_: Any, **__: Any) -> Any:
        self.tick = callback

    def _open(self, thing: Any) -> Any:
        if isinstance(thing, Subscription):
            self.receive = thing._receive
        return super()._open(thing)
