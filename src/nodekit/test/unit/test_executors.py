"""Tests of executors with real threads: overlap, counters, failures and shutdown."""

import itertools
import queue
import threading
import time
from typing import Any, Callable, Iterator, List, Optional, Type

import pytest
import rospy
from std_msgs.msg import String

from nodekit.executors import MultiThreadedExecutor, SingleThreadedExecutor, _Executor
from nodekit.groups.callback_groups import CallbackGroup, Group, ReentrantCallbackGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.callbacks import (
    DEPTH,
    Callback,
    CoalescingCallback,
    ServiceCallback,
    SubscriptionCallback,
)
from nodekit.node.names import Names
from nodekit.node.node_scope import NodeScope
from nodekit.node.ros_node import Node
from nodekit.node.timers import NodeTimer
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until
from nodekit.timing.clocks import MonotonicClock
from nodekit.timing.scheduler import Scheduler

#: How long a callback is held while no other may begin [s].
HELD_S = 0.03
KINDS = ("timer", "subscription", "service", "on_change")
GROUPS = ("one exclusive", "two exclusive", "one reentrant")


@pytest.fixture(scope="module")
def scheduler() -> Iterator[Scheduler]:
    made = Scheduler(MonotonicClock())
    yield made
    made.close()


def executor(name: str) -> Optional[_Executor]:
    makers = {"single": SingleThreadedExecutor, "multi": lambda: MultiThreadedExecutor(4)}
    return makers[name]() if name in makers else None


def make(
    kind: str,
    group: CallbackGroup,
    function: Callable[[], Any],
    ready: Optional[ReadyQueue],
    clock: Scheduler,
) -> Callable[[], Any]:
    """Return a function that triggers one call of a callback, as in use."""
    callback: Callback
    if kind == "timer":
        timer = NodeTimer(clock, group, 0.001, lambda elapsed: function(), 0.0, kind)
        timer.attach(ready)
        return lambda: NodeTimer.start_together([timer])
    if kind == "subscription":
        callback = receiving = SubscriptionCallback(
            group, lambda message: function(), kind, batches=False
        )
        callback.attach(ready)
        return lambda: in_thread(receiving.receive, ["message"], True)
    if kind == "service":
        callback = answering = ServiceCallback(
            group, lambda request: function(), f"/{id(function)}"
        )
        callback.attach(ready)
        return lambda: in_thread(answering.respond, "request")
    callback = coalescing = CoalescingCallback(group, function, kind)
    callback.attach(ready)
    return lambda: in_thread(coalescing.trigger)


def overlap(one: str, other: str, groups: str, name: str) -> bool:
    """Compare with the documentation."""
    if name == "single" or groups == "one exclusive":
        return False
    return name == "multi" or (one, other) != ("timer", "timer")


@pytest.mark.parametrize("name", ["none", "single", "multi"])
@pytest.mark.parametrize("groups", GROUPS)
@pytest.mark.parametrize(
    "one, other", list(itertools.combinations_with_replacement(KINDS, 2)), ids=str
)
def test_overlapping_callbacks_by_executor_and_group(
    scheduler: Scheduler, one: str, other: str, groups: str, name: str
) -> None:
    made = executor(name)
    ready = made._ready if made is not None else None
    first_group: CallbackGroup = ReentrantCallbackGroup() if groups == "one reentrant" else Group()
    second_group = Group() if groups == "two exclusive" else first_group
    begun, may_end, second_begun = threading.Event(), threading.Event(), threading.Event()
    order: List[str] = []

    def first() -> None:
        order.append("first begins")
        begun.set()
        may_end.wait(TIMEOUT_S)
        order.append("first ends")

    def second() -> None:
        order.append("second begins")
        second_begun.set()

    make(one, first_group, first, ready, scheduler)()
    assert begun.wait(TIMEOUT_S)
    make(other, second_group, second, ready, scheduler)()
    if overlap(one, other, groups, name):
        assert second_begun.wait(TIMEOUT_S), order
        may_end.set()
        return
    assert not second_begun.wait(HELD_S), order
    may_end.set()
    assert second_begun.wait(TIMEOUT_S), order
    assert order == ["first begins", "first ends", "second begins"]


def receiving(
    made: _Executor,
    function: Callable[[Any], Any],
    group: Optional[CallbackGroup] = None,
    depth: Optional[int] = None,
) -> SubscriptionCallback:
    callback = SubscriptionCallback(group or Group(), function, "topic", False, depth)
    callback.attach(made._ready)
    return callback


def test_callback_in_a_reentrant_group_overlaps_itself_up_to_all_threads() -> None:
    made, inside, most = MultiThreadedExecutor(3), [0], [0]
    all_in = threading.Barrier(3)

    def callback(message: Any) -> None:
        inside[0] += 1
        most[0] = max(most[0], inside[0])
        all_in.wait(TIMEOUT_S)
        inside[0] -= 1

    receiving(made, callback, ReentrantCallbackGroup()).receive(list(range(6)), True)
    assert made.shutdown(TIMEOUT_S)
    assert most[0] == 3


def test_timer_keeps_running_while_ten_slow_messages_wait(scheduler: Scheduler) -> None:
    made = MultiThreadedExecutor(2)
    may_end, ticks = threading.Event(), threading.Semaphore(0)
    slow = receiving(made, lambda message: may_end.wait(TIMEOUT_S), depth=11)
    slow.receive(list(range(11)), True)
    timer = NodeTimer(scheduler, Group(), 100.0, lambda elapsed: ticks.release(), 0.0, "timer")
    timer.attach(made._ready)
    NodeTimer.start_together([timer])
    assert all(ticks.acquire(timeout=TIMEOUT_S) for _ in range(5))
    assert slow.calls is not None and slow.calls.waiting == 10
    timer.close()
    may_end.set()
    assert made.shutdown(TIMEOUT_S)


def test_urgent_group_goes_first() -> None:
    made, order = SingleThreadedExecutor(), []  # type: Any
    begun, may_end = threading.Event(), threading.Event()

    def hold(message: Any) -> None:
        begun.set()
        may_end.wait(TIMEOUT_S)

    receiving(made, hold).receive(["hold"], True)
    assert begun.wait(TIMEOUT_S)
    receiving(made, order.append).receive([1, 2, 3], True)
    receiving(made, order.append, Group(urgent=True)).receive(["stop"], True)
    may_end.set()
    assert made.shutdown(TIMEOUT_S)
    assert order == ["stop", 1, 2, 3]


def test_newest_messages_are_kept_and_the_rest_is_counted() -> None:
    made, heard = SingleThreadedExecutor(), []  # type: Any
    callback = receiving(made, heard.append, depth=3)
    with callback.group:
        callback.receive(list(range(10)), True)
        assert callback.calls is not None
        assert (callback.calls.waiting, callback.calls.dropped) == (3, 7)
    assert made.shutdown(TIMEOUT_S)
    assert heard == [7, 8, 9]


def test_batch_takes_all_waiting_messages() -> None:
    made, heard = SingleThreadedExecutor(), []  # type: Any
    callback = SubscriptionCallback(Group(), heard.append, "topic", True, 100)
    callback.attach(made._ready)
    with callback.group:
        callback.receive([1, 2], True)
        callback.receive([3], True)
    assert made.shutdown(TIMEOUT_S)
    assert heard == [[1, 2, 3]]


def test_missed_periods_are_skipped_and_counted(scheduler: Scheduler) -> None:
    made = SingleThreadedExecutor()
    begun, may_end, calls = threading.Event(), threading.Event(), []

    def tick(elapsed: float) -> None:
        calls.append(elapsed)
        begun.set()
        may_end.wait(TIMEOUT_S)

    timer = NodeTimer(scheduler, Group(), 200.0, tick, 0.0, "timer")
    timer.attach(made._ready)
    NodeTimer.start_together([timer])
    assert begun.wait(TIMEOUT_S)
    wait_until(lambda: timer.skipped >= 5, lambda: str(timer.skipped))
    assert len(calls) == 1
    may_end.set()
    wait_until(lambda: len(calls) > 2, lambda: str(calls))
    timer.close()


def test_timer_that_is_too_slow_for_its_rate_leaves_the_others_their_turns(
    scheduler: Scheduler,
) -> None:
    made, due = SingleThreadedExecutor(), threading.Semaphore(0)

    def slow(elapsed: float) -> None:
        skipped = timers[0].skipped
        wait_until(lambda: timers[0].skipped > skipped + 1, lambda: str(skipped))

    timers = [
        NodeTimer(scheduler, Group(), 200.0, slow, 0.0, "slow"),
        NodeTimer(scheduler, Group(), 200.0, lambda elapsed: due.release(), 0.0, "quick"),
    ]
    for timer in timers:
        timer.attach(made._ready)
    NodeTimer.start_together(timers)
    assert all(due.acquire(timeout=TIMEOUT_S) for _ in range(5))
    for timer in timers:
        timer.close()


@pytest.mark.parametrize("error", [ValueError, SystemExit, KeyboardInterrupt])
def test_failure_affects_nothing_else(error: Type[BaseException]) -> None:
    made, heard = SingleThreadedExecutor(), []  # type: Any

    def fail(message: Any) -> None:
        raise error("on purpose")

    failing = receiving(made, fail)
    failing.receive([1, 2], True)
    failing.group.wait_until_left(TIMEOUT_S)
    receiving(made, heard.append).receive(["after"], True)
    assert made.shutdown(TIMEOUT_S)
    assert heard == ["after"] and failing.errors.count == 2


def test_service_answers_with_the_error() -> None:
    made = SingleThreadedExecutor()

    def fail(request: Any) -> None:
        raise ValueError("on purpose")

    answering = ServiceCallback(Group(), fail, "/fails")
    answering.attach(made._ready)
    for _ in range(2):
        with pytest.raises(rospy.ServiceException, match="on purpose"):
            answering.respond("request")
    assert answering.errors.count == 2


def test_removed_while_running_calls_the_waiting_callbacks_and_the_rest_directly() -> None:
    made, threads = SingleThreadedExecutor(), []  # type: Any
    begun, may_end = threading.Event(), threading.Event()

    def callback(message: Any) -> None:
        threads.append((message, threading.current_thread().name))
        begun.set()
        may_end.wait(TIMEOUT_S)

    one = receiving(made, callback)
    one.receive([1, 2], True)
    assert begun.wait(TIMEOUT_S)
    one.attach(None)
    direct = in_thread(one.receive, [3], True)
    may_end.set()
    direct.join(TIMEOUT_S)
    assert made.shutdown(TIMEOUT_S)
    assert sorted(message for message, _ in threads) == [1, 2, 3]
    assert all((name == direct.name) == (message == 3) for message, name in threads)


def test_shutdown_logs_dropped_calls() -> None:
    made = MultiThreadedExecutor(2)
    begun, may_end = threading.Event(), threading.Event()
    heard: List[Any] = []

    def hold(message: Any) -> None:
        heard.append(message)
        begun.set()
        may_end.wait(TIMEOUT_S)

    callback = receiving(made, hold)
    callback.receive([1, 2, 3], True)
    answering = ServiceCallback(callback.group, lambda request: None, "/waits")
    answering.attach(made._ready)
    errors: List[str] = []

    def call() -> None:
        try:
            answering.respond("request")
        except rospy.ServiceException as error:
            errors.append(str(error))

    assert begun.wait(TIMEOUT_S)
    caller = in_thread(call)
    wait_until(lambda: bool(answering.calls and answering.calls.waiting), lambda: "no call")
    began = time.monotonic()
    assert not made.shutdown(0.05)
    assert time.monotonic() - began < TIMEOUT_S / 2
    may_end.set()
    caller.join(TIMEOUT_S)
    assert errors and "/waits" in errors[0] and "shut down" in errors[0]
    assert heard == [1]
    with pytest.raises(rospy.ServiceException, match="shut down"):
        answering.respond("request")
    assert callback.group.enter(TIMEOUT_S)


def test_close_waits_for_running_but_not_for_waiting_callbacks() -> None:
    made, began = SingleThreadedExecutor(), threading.Event()
    may_end = threading.Event()

    def hold(message: Any) -> None:
        began.set()
        may_end.wait(TIMEOUT_S)

    receiving(made, hold).receive([1], True)
    assert began.wait(TIMEOUT_S)
    heard: List[Any] = []
    waiting = receiving(made, heard.append)
    waiting.receive([1], True)
    waiting.close()
    start = time.monotonic()
    assert waiting.group.wait_until_left(TIMEOUT_S)
    assert time.monotonic() - start < TIMEOUT_S / 2
    may_end.set()
    assert made.shutdown(TIMEOUT_S)
    assert heard == []


@pytest.mark.parametrize("threads", [0, -1])
def test_invalid_number_of_threads_is_rejected(threads: int) -> None:
    with pytest.raises(ValueError, match=f"refused {threads}: must be"):
        MultiThreadedExecutor(threads)


def test_threads_not_yet_started_count(monkeypatch: "pytest.MonkeyPatch") -> None:
    """Or a call to another thread, made early, would be refused as one to the only thread."""
    monkeypatch.setattr(threading.Thread, "start", lambda thread: None)
    assert len(MultiThreadedExecutor(3)._ready.workers) == 3


@pytest.mark.parametrize("queue_size, kept", [(None, DEPTH), (3, 3), (-1, 50)])
def test_queue_holds_the_given_number_of_messages(queue_size: Optional[int], kept: int) -> None:
    made, node, heard = SingleThreadedExecutor(), Node(Names("/one", True)), []  # type: Any
    made.add_node(node)
    node.create_subscription("topic", String, heard.append, queue_size)
    (waiting,) = (each for each in node.callbacks() if isinstance(each, SubscriptionCallback))
    with waiting.group:
        waiting.receive(list(range(50)), True)
    assert made.shutdown(TIMEOUT_S)
    assert heard == list(range(50))[-kept:]


def test_callbacks_of_scopes_go_to_an_executor_and_back_with_their_node() -> None:
    made, node = SingleThreadedExecutor(), Node(Names("/one", True))
    threads: "queue.Queue[threading.Thread]" = queue.Queue()
    callbacks: List[SubscriptionCallback] = []

    def subscribe(scope: NodeScope) -> None:
        scope.create_subscription(
            "topic", String, lambda _: threads.put(threading.current_thread())
        )
        callbacks.extend(
            each for each in scope.callbacks() if isinstance(each, SubscriptionCallback)
        )

    def threads_of_calls() -> List[threading.Thread]:
        for callback in callbacks:
            callback.receive(["message"], True)
        return [threads.get(timeout=TIMEOUT_S) for _ in callbacks]

    subscribe(node.create_scope().create_scope())
    made.add_node(node)
    subscribe(node.create_scope())
    assert threads_of_calls() == [*made._ready.workers] * 2
    made.remove_node(node)
    assert threads_of_calls() == [threading.current_thread()] * 2
    assert made.shutdown(TIMEOUT_S)


@pytest.mark.parametrize("queue_size", [0, -2, 1.5, "10"])
def test_invalid_queue_size_is_rejected(queue_size: Any) -> None:
    with pytest.raises(ValueError, match=f"queue_size: refused {queue_size!r}: must be"):
        Node(Names("/one", True)).create_subscription("topic", String, print, queue_size)


@pytest.mark.parametrize("other", [True, False])
def test_node_removed_from_a_shut_down_executor_keeps_working(
    scheduler: Scheduler, other: bool
) -> None:
    gone = SingleThreadedExecutor()
    ticks, calls_made = threading.Event(), threading.Event()
    timer = NodeTimer(scheduler, Group(), 100.0, lambda elapsed: ticks.set(), 0.0, "timer")
    coalescing = CoalescingCallback(Group(), calls_made.set, "coalescing")
    callbacks: List[Callback] = [timer, coalescing]
    for callback in callbacks:
        callback.attach(gone._ready)
    assert gone.shutdown(TIMEOUT_S)
    coalescing.trigger()
    NodeTimer.start_together([timer])
    wait_until(lambda: timer.calls and timer.calls.dropped > 1, lambda: "no tick was dropped")
    assert not (ticks.is_set() or calls_made.is_set())
    new = SingleThreadedExecutor() if other else None
    for callback in callbacks:
        callback.attach(new._ready if new else None)
    coalescing.trigger()
    assert calls_made.wait(TIMEOUT_S) and ticks.wait(TIMEOUT_S)
    timer.close()
