"""ResourceOwner: owns resources, and closes them when it is closed."""

import threading
import time
import traceback
from typing import Any, List, Set, TypeVar

import rospy

from nodekit.groups.callback_groups import CallbackGroup
from nodekit.node.callbacks import Callback
from nodekit.node.start_queue import StartQueue
from nodekit.rospy_internals import registration_listener
from nodekit.transport import delivery

Thing = TypeVar("Thing")

#: Longest wait on closing for callbacks that are running [s].
CLOSE_WAIT_S = 1.0


class Closed(RuntimeError):
    """Error of creating a resource through an owner that is closed."""


class ResourceOwner:
    """Opens resources through a start queue, and closes them together.

    :param start_queue: opens them at the node's start, later ones immediately
    """

    def __init__(self, start_queue: StartQueue) -> None:
        self._start_queue = start_queue
        self._owned: List[Any] = []
        self._closed = False
        self._lock = threading.Lock()

    def own(self, thing: Thing) -> Thing:
        """Close a resource together with the others.

        :param thing: anything with a method ``close``
        :returns: the resource
        :raises Closed: if the owner is closed
        """
        with self._lock:
            if self._closed:
                raise Closed(f"{self} is closed and cannot create anything")
            self._owned.append(thing)
        return thing

    def disown(self, thing: object) -> None:
        """Remove a resource that was closed.

        :param thing: argument of :meth:`own`
        """
        with self._lock:
            self._owned = [other for other in self._owned if other is not thing]

    def close(self) -> None:
        """Close all resources, the latest first; a second call has no effect.

        No callback starts after this has returned. Running callbacks except the caller's own are
        waited for, up to :data:`CLOSE_WAIT_S`.
        """
        groups: Set[CallbackGroup] = set()
        with registration_listener.together(), delivery.closing_together():
            self._close_all(groups)
        deadline = time.monotonic() + CLOSE_WAIT_S
        for group in groups:
            group.wait_until_left(max(0.0, deadline - time.monotonic()))

    def _open(self, thing: Thing) -> Thing:
        """Own a resource, and open it now or at the start."""
        self.own(thing)
        self._start_queue.add([thing])
        return thing

    def _close_all(self, groups: Set[CallbackGroup]) -> None:
        """Close all resources without waiting for callbacks.

        :param groups: collects the groups whose callbacks may be running
        """
        with self._lock:
            self._closed = True
            owned, self._owned = self._owned, []
        self._start_queue.remove(owned)
        for thing in reversed(owned):
            try:
                if isinstance(thing, ResourceOwner):
                    thing._close_all(groups)
                else:
                    if isinstance(thing, Callback):
                        groups.add(thing.group)
                    thing.close()
            except Exception:  # one failure must not leave the others open
                rospy.logerr("closing %s failed:\n%s", thing, traceback.format_exc())
