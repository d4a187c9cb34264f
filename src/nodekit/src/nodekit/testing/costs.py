"""Cost of a call by an executor, measured without ROS; deprecated, kept in 1.x."""

import statistics
import threading
import time
import timeit
import warnings
from typing import Any, Callable, List, Union

from nodekit.executors import MultiThreadedExecutor, SingleThreadedExecutor
from nodekit.groups.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from nodekit.groups.ready_queue import CallQueue
from nodekit.node.callbacks import Callback

warnings.warn("nodekit.testing.costs: deprecated module; copy it", DeprecationWarning, 2)

Executor = Union[SingleThreadedExecutor, MultiThreadedExecutor]

#: How many calls are measured.
CALLS, DELAYED, IN_GROUP = 50_000, 300, 100_000
#: Longest time for all of them, s.
LIMIT_S = 120.0


def processor_time(executor: Executor, group: CallbackGroup) -> float:
    """Measure the calls of an executor, all of which arrive before the first begins.

    :param executor: makes them
    :param group: the group of the callback
    :returns: processor time of a call from its arrival to its end, us
    :raises RuntimeError: if calls are lost
    """
    filled, done = threading.Event(), threading.Event()
    left = [CALLS]

    def run(things: List[Any]) -> None:
        filled.wait(LIMIT_S)
        if things[0] == CALLS - 1:
            done.set()

    calls = CallQueue(executor._ready, group, CALLS, run, lambda thing: left.clear())
    began = time.process_time()
    for number in range(CALLS):
        calls.put(number)
    filled.set()
    if not done.wait(LIMIT_S) or not left:
        raise RuntimeError("calls were lost")
    return (time.process_time() - began) / CALLS * 1e6


def delay(executor: Executor) -> float:
    """Measure how late an executor whose threads are idle makes a call.

    :param executor: makes the calls
    :returns: median time from an arrival to its call, us
    """
    delays: List[float] = []
    called = threading.Event()

    def run(things: List[float]) -> None:
        delays.append(time.perf_counter() - things[0])
        called.set()

    calls = CallQueue(executor._ready, MutuallyExclusiveCallbackGroup(), 1, run, lambda thing: None)
    for _ in range(DELAYED):
        called.clear()
        calls.put(time.perf_counter())
        called.wait(LIMIT_S)
        time.sleep(0.001)
    return statistics.median(delays) * 1e6


def time_in_a_group() -> float:
    """Measure the cost of mutual exclusion between a node's callbacks.

    :returns: by how much a call takes longer in a group without contention [us]
    """

    def nothing() -> None:
        pass

    subjects: List[Callable[[], None]] = [
        nothing,
        Callback(MutuallyExclusiveCallbackGroup(), nothing, "nothing").call,
    ]
    by_itself, in_group = (
        min(timeit.repeat(function, number=IN_GROUP, repeat=5)) / IN_GROUP for function in subjects
    )
    return (in_group - by_itself) * 1e6
