"""Cost of a call by an executor of nodekit, measured without ROS."""

import statistics
import threading
import time
from typing import Any, List, Union

from nodekit.groups.ready_queue import CallQueue

from nodekit import CallbackGroup, Group, MultiThreadedExecutor, SingleThreadedExecutor

Executor = Union[SingleThreadedExecutor, MultiThreadedExecutor]

#: Numbers of measured calls.
CALLS, DELAYED = 50_000, 300
#: Longest time for all of them [s].
LIMIT_S = 120.0


def processor_time(executor: Executor, group: CallbackGroup) -> float:
    """Return the processor time of a call; all calls arrive before the first begins.

    :param executor: makes the calls
    :param group: the group of the callback
    :returns: processor time of a call from its arrival to its end [us]
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
    """Return the delay of a call by an executor whose threads are idle.

    :param executor: makes the calls
    :returns: median time from an arrival to its call [us]
    """
    delays: List[float] = []
    called = threading.Event()

    def run(things: List[float]) -> None:
        delays.append(time.perf_counter() - things[0])
        called.set()

    calls = CallQueue(executor._ready, Group(), 1, run, lambda thing: None)
    for _ in range(DELAYED):
        called.clear()
        calls.put(time.perf_counter())
        called.wait(LIMIT_S)
        time.sleep(0.001)
    return statistics.median(delays) * 1e6
