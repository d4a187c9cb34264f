"""State shared by a node and its scopes: names, callback group, ready queue, live parameters."""

from typing import Any, Optional

from nodekit.groups.callback_groups import MutuallyExclusiveCallbackGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.names import Names
from nodekit.node.start_queue import StartQueue
from nodekit.node.timers import ParameterRates
from nodekit.parameter_server.live_parameters import LiveParameters


class NodeContext:
    """State that all scopes of a node share.

    :param names: resolves the node's names
    :param start_queue: opens the scopes' resources

    :ivar group: the default group of callbacks
    :ivar rates: timers whose rates follow the node's parameters
    :ivar ready: ready queue of the node's executor; None without an executor
    :ivar live: the parameters declared last; None before a declaration
    """

    __slots__ = ("names", "start_queue", "group", "rates", "ready", "live")

    def __init__(self, names: Names, start_queue: StartQueue) -> None:
        self.names, self.start_queue = names, start_queue
        self.group, self.rates = MutuallyExclusiveCallbackGroup(), ParameterRates()
        self.ready: Optional[ReadyQueue] = None
        self.live: Optional[LiveParameters[Any]] = None
