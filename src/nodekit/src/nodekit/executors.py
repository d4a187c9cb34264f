"""Executors: threads that run the callbacks of nodes, as in ROS 2.

Without an executor, rospy's threads run them: one per connection, one for all timers. That is
fast and loses nothing, but a slow callback delays all others of its thread. An executor has its own
threads, so timers and services may take long; messages that arrive faster than they are handled are
dropped, the oldest first, as in ROS 2.
"""

import contextlib
import os
import threading
from typing import Any, Dict, Optional

import yaml
from std_srvs.srv import Trigger, TriggerResponse

from nodekit.argument_checks import LONGEST_S, check_wait
from nodekit.groups.callback_groups import NoGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.callbacks import Callback
from nodekit.node.node_scope import NodeScope
from nodekit.node.resource_owner import Closed
from nodekit.node.ros_node import Node
from nodekit.node.timers import NodeTimer
from nodekit.process_context import PROCESS
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end

#: Base name of the service that reports a node's callbacks.
SERVICE = "executor"


class _Executor:
    """Executor: runs the callbacks of added nodes until it is shut down.

    :param threads: most calls at the same time
    :raises ValueError: if that is less than 1
    """

    def __init__(self, threads: int) -> None:
        if threads < 1:
            raise ValueError(f"threads: refused {threads!r}: must be a whole number of at least 1")
        self._ready = ReadyQueue()
        self._reports: Dict[Node, NodeScope] = {}
        number = PROCESS.next_number(_Executor)
        for count in range(1, threads + 1):
            name = f"executor-{number}-{count}"
            self._ready.workers.add(threading.Thread(target=self._work, name=name, daemon=True))
        for worker in self._ready.workers:
            worker.start()
        PROCESS.instances(_Executor).add(self)

    def add_node(self, node: Node) -> None:
        """Run a node's callbacks from now on: timers, messages, services, parameter changes.

        The node is removed from its previous executor. Nodes that it hosts must be added
        separately. A closed node has no callbacks to run.

        :param node: the node, started or not
        """
        if node.executor is self:
            return
        if node.executor is not None:
            node.executor.remove_node(node)
        node.executor = self
        node.attach(self._ready)
        with contextlib.suppress(Closed):  # closed by another thread or before
            report = self._reports[node] = node.create_scope()
            report.create_service(f"~{SERVICE}", Trigger, lambda _: _report(node), group=NoGroup())

    def remove_node(self, node: Node) -> None:
        """Stop running a node's callbacks; rospy's threads run them again.

        Waiting calls are still made.

        :param node: a node that was added
        """
        if node.executor is self:
            node.executor = None
            node.attach(None)
            report = self._reports.pop(node, None)  # None if the node was closed already
            if report is not None:
                report.close()

    def shutdown(self, timeout: float = 1.0) -> bool:
        """Make the waiting calls and accept no others; drop those not made in time.

        :param timeout: longest wait [s]
        :returns: whether all calls were made
        :raises ValueError: if the time-out is not a number
        """
        check_wait(timeout)
        return self._ready.close(min(timeout, LONGEST_S))

    def _work(self) -> None:
        while True:
            call = self._ready.next_call()
            if call is None:
                return
            self._ready.make_call(call)


class SingleThreadedExecutor(_Executor):
    """Executor that runs one callback at a time, whatever their callback groups."""

    def __init__(self) -> None:
        super().__init__(1)


class MultiThreadedExecutor(_Executor):
    """Executor that runs callbacks in parallel, as far as their callback groups allow.

    :param threads: number of threads; by default one per core, at least two
    :raises ValueError: if that is less than 1
    """

    def __init__(self, threads: Optional[int] = None) -> None:
        super().__init__(max(2, os.cpu_count() or 1) if threads is None else threads)


def _report(node: Node) -> TriggerResponse:
    entries = [entry for entry in map(_entry, node.callbacks()) if entry is not None]
    return TriggerResponse(True, yaml.safe_dump(entries, sort_keys=False))


def _entry(callback: Callback) -> Optional[Dict[str, Any]]:
    """Return the report of a callback; None if no executor makes its calls."""
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
        "failed": callback.errors.count,
        "longest": round(calls.longest, 6),
        "longest_wait": round(calls.longest_wait, 6),
    }


def _shut_down_all() -> None:
    for executor in list(PROCESS.instances(_Executor)):
        executor.shutdown(0.0)


at_end(ShutdownPhase.TOOLKIT, _shut_down_all)
