"""Executors: how many threads make the calls of which nodes.

Without one, rospy's threads make them: a thread for each connection, one for all timers. That is
quick and loses nothing, but a callback that takes its time holds up whoever shares its thread. An
executor has threads of its own, so timers and services may take long; what comes quicker than it is
handled is dropped, the oldest first, as ROS 2 does it.
"""

import contextlib
import itertools
import os
import threading
import weakref
from typing import Any, Dict, Optional

import yaml
from std_srvs.srv import Trigger, TriggerResponse

from nodekit.groups.callback_groups import NoGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.callbacks import Callback
from nodekit.node.node import Node
from nodekit.node.node_scope import NodeScope
from nodekit.node.resource_owner import Closed
from nodekit.node.timers import NodeTimer
from nodekit.rospy_internals.shutdown import Ending, at_end
from nodekit.validation import LONGEST_S, check_wait

#: Base name of the service that tells of a node's callbacks.
SERVICE = "executor"

_numbers = itertools.count(1)


class _Executor:
    """Makes the calls of the nodes that are added to it, until it is shut down.

    :param threads: how many calls are made at once, at most
    :raises ValueError: if that is less than 1
    """

    def __init__(self, threads: int) -> None:
        if threads < 1:
            raise ValueError(f"threads: refused {threads!r}: must be a whole number of at least 1")
        self._ready = ReadyQueue()
        self._reports: Dict[Node, NodeScope] = {}
        number = next(_numbers)
        for count in range(1, threads + 1):
            name = f"executor-{number}-{count}"
            self._ready.workers.add(threading.Thread(target=self._work, name=name, daemon=True))
        for worker in self._ready.workers:
            worker.start()
        _executors.add(self)

    def add_node(self, node: Node) -> None:
        """Make the calls of a node from now on: its timers, subscriptions, services, changes.

        A node that was with another executor leaves that. Nodes that it hosts are added apart. One
        that is closed has no calls to be made.

        :param node: started or not
        """
        if node.executor is self:
            return
        if node.executor is not None:
            node.executor.remove_node(node)
        node.executor = self
        node.attach(self._ready)
        with contextlib.suppress(Closed):  # by another thread, or before: it has no more calls
            report = self._reports[node] = node.create_scope()
            report.create_service(f"~{SERVICE}", Trigger, lambda _: _tell_of(node), group=NoGroup())

    def remove_node(self, node: Node) -> None:
        """Make no calls of a node from now on; rospy's threads make them again.

        What waits by then is still called.

        :param node: one that was added
        """
        if node.executor is self:
            node.executor = None
            node.attach(None)
            report = self._reports.pop(node, None)  # none where it was closed already
            if report is not None:
                report.close()

    def shutdown(self, timeout: float = 1.0) -> bool:
        """Make the calls that wait, and no more; what cannot be done in time is dropped.

        :param timeout: longest wait for that, s
        :returns: whether all calls were made
        :raises ValueError: if the time-out is no number
        """
        check_wait(timeout)
        return self._ready.close(min(timeout, LONGEST_S))

    def _work(self) -> None:
        while True:
            turn = self._ready.next_call()
            if turn is None:
                return
            self._ready.make_call(turn)


class SingleThreadedExecutor(_Executor):
    """Makes one call after the other, whatever their groups."""

    def __init__(self) -> None:
        super().__init__(1)


class MultiThreadedExecutor(_Executor):
    """Makes calls at once, as far as their groups allow.

    :param threads: how many, at most; by default as many as the machine has cores, but two
    :raises ValueError: if that is less than 1
    """

    def __init__(self, threads: Optional[int] = None) -> None:
        super().__init__(max(2, os.cpu_count() or 1) if threads is None else threads)


def _tell_of(node: Node) -> TriggerResponse:
    entries = [entry for entry in map(_entry, node.callbacks()) if entry is not None]
    return TriggerResponse(True, yaml.safe_dump(entries, sort_keys=False))


def _entry(callback: Callback) -> Optional[Dict[str, Any]]:
    """Return what is told of a callback; None if no executor makes its calls."""
    calls = callback.calls
    if calls is None:
        return None
    return {
        "name": callback.what,
        "kind": callback.kind,
        "waiting": calls.waiting,
        "running": calls.running,
        "made": calls.made,
        "dropped": calls.dropped,
        "skipped": callback.skipped if isinstance(callback, NodeTimer) else 0,
        "failed": callback.failures.count,
        "longest": round(calls.longest, 6),
        "longest_wait": round(calls.longest_wait, 6),
    }


_executors: "weakref.WeakSet[_Executor]" = weakref.WeakSet()


def _shut_all_down() -> None:
    for executor in list(_executors):
        executor.shutdown(0.0)


at_end(Ending.TOOLKIT, _shut_all_down)
