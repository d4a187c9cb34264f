"""State that all scopes of a node share."""

from typing import Any, Optional

from nodekit.groups.callback_groups import MutuallyExclusiveCallbackGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.names import Names
from nodekit.node.opening import Opener
from nodekit.node.timers import RateFollowers
from nodekit.parameter_server.live_parameters import LiveParameters


class NodeContext:
    """State that all scopes of a node share.

    :param names: resolves the node's names
    :param opener: opens what the scopes create

    :ivar group: the default group of callbacks
    :ivar rates: timers whose rates follow the node's parameters
    :ivar ready: the queue of the executor that makes the calls, None without an executor
    :ivar live: the parameters declared last, None before
    """

    __slots__ = ("names", "opener", "group", "rates", "ready", "live")

    def __init__(self, names: Names, opener: Opener) -> None:
        self.names, self.opener = names, opener
        self.group, self.rates = MutuallyExclusiveCallbackGroup(), RateFollowers()
        self.ready: Optional[ReadyQueue] = None
        self.live: Optional[LiveParameters[Any]] = None
