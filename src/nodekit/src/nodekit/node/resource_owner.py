"""What somebody has made is theirs, and is closed with them."""

import threading
import time
import traceback
from typing import Any, List, Set, TypeVar

import rospy

from nodekit.groups.callback_groups import CallbackGroup
from nodekit.node.callbacks import Callback
from nodekit.node.start_queue import StartQueue
from nodekit.rospy_internals import registration

Thing = TypeVar("Thing")

#: Longest wait on closing for callbacks that are running [s].
CLOSE_WAIT_S = 1.0


class Closed(RuntimeError):
    """Something was to be made by what is closed."""


class ResourceOwner:
    """Has things opened, and closes them.

    :param start_queue: opens them at the node's start, or at once after it
    """

    def __init__(self, start_queue: StartQueue) -> None:
        self._start_queue = start_queue
        self._made: List[Any] = []
        self._closed = False
        self._lock = threading.Lock()

    def own(self, thing: Thing) -> Thing:
        """Close something with the rest.

        :param thing: anything with a method ``close``
        :returns: the thing
        :raises Closed: if the owner is closed
        """
        with self._lock:
            if self._closed:
                raise Closed(f"{self} is closed and creates nothing more")
            self._made.append(thing)
        return thing

    def disown(self, thing: object) -> None:
        """Forget something that was closed.

        :param thing: what :meth:`own` was given
        """
        with self._lock:
            self._made = [other for other in self._made if other is not thing]

    def close(self) -> None:
        """Close all that was made, the latest first; without effect a second time.

        No callback of it begins after this has returned. Those under way are waited for, but not
        the caller's own, and not for longer than :data:`CLOSE_WAIT_S`.
        """
        groups: Set[CallbackGroup] = set()
        with registration.together():
            self._shut(groups)
        deadline = time.monotonic() + CLOSE_WAIT_S
        for group in groups:
            group.wait_until_left(max(0.0, deadline - time.monotonic()))

    def _open(self, thing: Thing) -> Thing:
        """Own a thing, and open it now or at the start."""
        self.own(thing)
        self._start_queue.add([thing])
        return thing

    def _shut(self, groups: Set[CallbackGroup]) -> None:
        """Close everything without waiting.

        :param groups: takes in the groups whose callbacks may be under way
        """
        with self._lock:
            self._closed = True
            made, self._made = self._made, []
        self._start_queue.forget(made)
        for thing in reversed(made):
            try:
                if isinstance(thing, ResourceOwner):
                    thing._shut(groups)
                else:
                    if isinstance(thing, Callback):
                        groups.add(thing.group)
                    thing.close()
            except Exception:  # what fails must not keep the rest open
                rospy.logerr("closing %s failed:\n%s", thing, traceback.format_exc())
