"""Wait loop for messages, requests and responses from ROS 2, in its own thread.

It reuses one wait set, and takes everything available before it waits again: rclpy's executors need
eight times the CPU time for the same work.
"""

import contextlib
import threading
import time
import traceback
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

import rospy
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from nodekit import Throttle

#: Most items taken from one waitable before the next has its turn.
_MOST = 1000
_KINDS = ("subscription", "client", "service")
#: Pause after a failed wait [s].
_PAUSE_S = 0.2
#: Shortest time between two log lines about exceptions of one function [s].
_LOG_PERIOD_S = 1.0


class Waitable(NamedTuple):
    """An entity that a wait set can wait for.

    :param kind: subscription, client or service
    :param entity: rclpy's object
    :param receive: takes up to the given number of items; called in the loop's thread
    """

    kind: str
    entity: Any
    receive: Callable[[int], None]


class WaitLoop:
    """Loop that receives messages, requests and responses as soon as they arrive.

    :param context: rclpy's
    :param name: of the thread
    """

    def __init__(self, context: Any, name: str) -> None:
        self._context = context
        self._lock = threading.Lock()
        self._waitables: Dict[int, Waitable] = {}
        self._pending_calls: List[Callable[[], None]] = []
        #: Entities whose receive() is called again without waiting; of the loop's thread.
        self._unfinished: List[Waitable] = []
        self._changed, self._ended = True, False
        self._throttle = Throttle(_LOG_PERIOD_S)
        with context.handle:
            self._wake_up = _rclpy.GuardCondition(context.handle)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def add(self, waitable: Waitable) -> None:
        """Add an entity."""
        with self._lock:
            self._waitables[id(waitable.entity)] = waitable
            self._changed = True
        self._trigger()

    def remove(self, waitable: Waitable, destroy: Callable[[], None]) -> None:
        """Remove an entity.

        :param destroy: called once no loop waits for it
        """
        with self._lock:
            self._waitables.pop(id(waitable.entity), None)
        self.call_between_waits(destroy)

    def call_between_waits(self, function: Callable[[], None]) -> None:
        """Call a function in the loop's thread, between two waits."""
        with self._lock:
            self._pending_calls.append(function)
            self._changed = True
        self._trigger()

    def call_again(self, waitable: Waitable) -> None:
        """Let an entity receive again after the others; called by its ``receive``."""
        self._unfinished.append(waitable)

    def close(self) -> None:
        """Stop the thread, and join it."""
        self._ended = True
        self._trigger()
        if threading.current_thread() is not self._thread:
            self._thread.join(1.0)

    def _trigger(self) -> None:
        with self._wake_up:
            self._wake_up.trigger_guard_condition()

    def _run(self) -> None:
        while not self._ended:
            if not self._guarded(self._wait_until_changed) and not self._ended:
                time.sleep(_PAUSE_S)

    def _wait_until_changed(self) -> None:
        with self._lock:
            waitables = list(self._waitables.values())
            between, self._pending_calls = self._pending_calls, []
            self._changed = False
        self._unfinished = [one for one in self._unfinished if one in waitables]
        for function in between:
            self._guarded(function)
        with contextlib.ExitStack() as held:
            wait_set, by_kind = self._fill(waitables, held)
            while not (self._changed or self._ended):
                self._wait(wait_set, by_kind)

    def _fill(
        self, waitables: List[Waitable], held: contextlib.ExitStack
    ) -> Tuple[Any, List[Tuple[str, Any, Dict[int, Waitable]]]]:
        """Build a wait set; hold its entities, so that they are not destroyed."""
        by_kind = []
        held.enter_context(self._context.handle)
        held.enter_context(self._wake_up)
        for kind in _KINDS:
            mine = {}
            for waitable in waitables:
                with contextlib.suppress(_rclpy.InvalidHandle):  # destroyed with its node
                    if waitable.kind == kind:
                        held.enter_context(waitable.entity.handle)
                        mine[waitable.entity.handle.pointer] = waitable
            by_kind.append((kind, f"add_{kind}", mine))
        counts = {kind: len(mine) for kind, _, mine in by_kind}
        wait_set = _rclpy.WaitSet(
            counts["subscription"],
            1,  # the trigger
            0,
            counts["client"],
            counts["service"],
            0,
            self._context.handle,
        )
        held.enter_context(wait_set)
        return wait_set, [(kind, getattr(wait_set, add), mine) for kind, add, mine in by_kind]

    def _wait(self, wait_set: Any, by_kind: List[Tuple[str, Any, Dict[int, Waitable]]]) -> None:
        wait_set.clear_entities()
        wait_set.add_guard_condition(self._wake_up)
        for _, add, mine in by_kind:
            for waitable in mine.values():
                add(waitable.entity.handle)
        wait_set.wait(0 if self._unfinished else -1)
        unfinished, self._unfinished = self._unfinished, []
        for waitable in unfinished:
            self._guarded(waitable.receive, _MOST)
        for kind, _, mine in by_kind:
            if mine:
                for pointer in wait_set.get_ready_entities(kind):
                    if mine[pointer] not in unfinished:
                        self._guarded(mine[pointer].receive, _MOST)

    def _guarded(self, function: Callable[..., None], *arguments: Any) -> bool:
        """Call a function; log its exceptions.

        :returns: whether it raised none
        """
        try:
            function(*arguments)
        except Exception:
            if not rospy.is_shutdown():
                name = getattr(function, "__qualname__", repr(function))
                if self._throttle.is_due(name):
                    rospy.logerr(traceback.format_exc())
            return False
        return True
