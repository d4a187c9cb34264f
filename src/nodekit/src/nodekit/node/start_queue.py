"""StartQueue: opens a node's topics, services and timers once its constructor has returned."""

import threading
from typing import Any, Iterable, List, Optional, Union

from nodekit.messaging.publisher import Publisher
from nodekit.messaging.service import Service
from nodekit.messaging.subscription import Subscription
from nodekit.node.callbacks import Callback
from nodekit.node.parameter_callbacks import ChangeCallback, ParameterCallback
from nodekit.node.timers import NodeTimer
from nodekit.parameter_server import followed_parameter, live_parameters
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.rospy_internals import registration_listener


class StartQueue:
    """Queue of resources to open at the start; opens later ones immediately."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: Optional[List[Any]] = []

    @property
    def has_started(self) -> bool:
        """Whether resources are opened immediately."""
        return self._waiting is None

    def add(self, things: List[Any]) -> None:
        """Open resources now or at the start.

        :param things: publishers, services, subscriptions, parameters, timers
        """
        with self._lock:
            if self._waiting is not None:
                self._waiting += things
                return
        _open_together(things)

    def remove(self, things: Iterable[Any]) -> None:
        """Remove resources that were closed before the start.

        :param things: resources that were added
        """
        gone = set(map(id, things))
        with self._lock:
            if self._waiting is not None:
                self._waiting = [thing for thing in self._waiting if id(thing) not in gone]

    def start(self) -> None:
        """Open the resources created so far."""
        with self._lock:
            waiting, self._waiting = self._waiting, None
        _open_together(waiting or [])


def _open_together(things: List[Any]) -> None:
    """Open resources with a few requests to the master, those with callbacks last."""
    subscriptions = [thing for thing in things if isinstance(thing, Subscription)]
    with registration_listener.together():
        for thing in things:
            if isinstance(thing, (Publisher, Service)):
                thing.open()
        for subscription in subscriptions:
            subscription.open()
    for subscription in subscriptions:
        subscription.receive_latched()
    # Another thread may close some of the rest, before or while they are opened.
    rest = [
        thing
        for thing in things
        if isinstance(thing, (Callback, LiveParameters)) and not _is_closed(thing)
    ]
    followed = [thing for thing in rest if isinstance(thing, ParameterCallback)]
    live_parameters.open_all([thing for thing in rest if isinstance(thing, LiveParameters)])
    followed_parameter.open_all([one.followed for one in followed])
    for thing in rest:
        if isinstance(thing, (ChangeCallback, ParameterCallback)):
            thing.start()
    NodeTimer.start_together([thing for thing in rest if isinstance(thing, NodeTimer)])
    for thing in rest:
        if _is_closed(thing):
            thing.close()


def _is_closed(thing: Union[Callback, LiveParameters[Any]]) -> bool:
    return thing.closed if isinstance(thing, Callback) else thing.is_closed
