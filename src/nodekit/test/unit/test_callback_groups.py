"""Tests of callback groups: exclusion, order, queued work, and threads that never wait."""

import threading
import time
from typing import Any, Callable, List

import pytest

from nodekit.groups.callback_groups import CallbackGroup, Group, ReentrantCallbackGroup
from nodekit.node.callbacks import Callback, CoalescingCallback, SubscriptionCallback
from nodekit.testing.waiting import in_thread

TIMEOUT_S = 10.0


class Busy:
    """A callback in a group that runs until it is released."""

    def __init__(self, group: CallbackGroup) -> None:
        self.inside = threading.Event()
        self.go_on = threading.Event()
        callback = Callback(group, self._run, "busy")
        self.thread = threading.Thread(target=callback.call, daemon=True)
        self.thread.start()
        assert self.inside.wait(TIMEOUT_S)

    def _run(self) -> None:
        self.inside.set()
        assert self.go_on.wait(TIMEOUT_S)

    def end(self) -> None:
        self.go_on.set()
        self.thread.join(TIMEOUT_S)
        assert not self.thread.is_alive()


def queued(group: CallbackGroup, count: int) -> None:
    """Wait until a number of threads wait for a group."""
    deadline = time.monotonic() + TIMEOUT_S
    while len(group._queue) < count:
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_callbacks_of_one_group_never_overlap_and_all_are_called() -> None:
    group, inside, calls = Group(), [0], [0]

    def work() -> None:
        inside[0] += 1
        assert inside[0] == 1
        calls[0] += 1
        time.sleep(0)  # lets the others in, if anything does
        inside[0] -= 1

    callback = Callback(group, work, "work")
    threads = [in_thread(lambda: [callback.call() for _ in range(500)]) for _ in range(4)]
    coalescing = CoalescingCallback(group, work, "work")
    for _ in range(500):
        coalescing.trigger()
    for thread in threads:
        thread.join(TIMEOUT_S)
    assert 2000 < calls[0] <= 2500
    assert not group._queue and not group._holder


def test_waiters_are_served_in_order_of_arrival() -> None:
    group, order = Group(), []  # type: Any
    busy = Busy(group)
    threads = []
    for number in range(6):
        if number % 2:
            group.offer(lambda number=number: order.append(number))
        else:
            threads.append(in_thread(Callback(group, order.append, "").call, number))
        queued(group, number + 1)
    busy.end()
    for thread in threads:
        thread.join(TIMEOUT_S)
    assert order == [0, 1, 2, 3, 4, 5]


def test_thread_that_is_inside_enters_again_without_waiting() -> None:
    group = Group()
    calls: List[str] = []

    def outer() -> None:
        Callback(group, lambda: calls.append("inner"), "").call()
        calls.append("outer")

    Callback(group, outer, "").call()
    assert calls == ["inner", "outer"]
    assert not group._holder


def test_waiting_for_a_group_does_not_wait_for_the_callers_own_callback() -> None:
    group = Group()
    with group:
        assert group.enter()
        group.leave()
        assert group.wait_until_left(0.0)
        assert group._holder
    assert not group._holder


def test_work_offered_from_inside_is_done_after_the_callback() -> None:
    group, calls = Group(), []  # type: Any
    coalescing = CoalescingCallback(group, lambda: calls.append("work"), "")

    def callback() -> None:
        coalescing.trigger()
        calls.append("callback")

    Callback(group, callback, "").call()
    assert calls == ["callback", "work"]


def test_offering_never_waits_and_the_leaving_thread_does_the_work() -> None:
    group = Group()
    busy, threads = Busy(group), []  # type: Any
    group.offer(lambda: threads.append(threading.current_thread()))
    assert threads == []
    busy.end()
    assert threads == [busy.thread]


def test_bell_that_rings_again_and_again_is_answered_once() -> None:
    group, calls = Group(), []  # type: Any
    coalescing = CoalescingCallback(group, lambda: calls.append(1), "")
    busy = Busy(group)
    for _ in range(5):
        coalescing.trigger()
    busy.end()
    assert calls == [1]
    coalescing.trigger()
    assert calls == [1, 1]


def test_bell_that_rings_while_it_is_answered_is_answered_again() -> None:
    calls: List[int] = []
    coalescing = CoalescingCallback(
        Group(), lambda: (calls.append(1), coalescing.trigger() if len(calls) < 3 else None), ""
    )
    coalescing.trigger()
    assert calls == [1, 1, 1]


def test_waiting_for_a_group_can_be_limited() -> None:
    group = Group()
    busy = Busy(group)
    assert not group.enter(0.01)
    assert not group.wait_until_left(0.01)
    assert not group._queue
    busy.end()
    assert group.wait_until_left(0.0)
    assert not group._holder


@pytest.mark.parametrize("kind", [Group, ReentrantCallbackGroup])
def test_waiting_for_a_group_ends_when_it_is_left(kind: Callable[[], Group]) -> None:
    group = kind()
    assert group.enter()
    group.leave()
    busy = Busy(group)
    threading.Timer(0.05, busy.go_on.set).start()
    assert group.wait_until_left(TIMEOUT_S)
    busy.end()
    assert group.wait_until_left(0.0)


def test_callback_waits_for_its_group_without_a_limit() -> None:
    group, calls = Group(), []  # type: Any
    busy = Busy(group)
    waits = in_thread(Callback(group, lambda: calls.append(1), "").call)
    waits.join(1.1)
    assert calls == []
    busy.end()
    waits.join(TIMEOUT_S)
    assert calls == [1]


def test_turn_at_the_moment_of_the_timeout_is_taken() -> None:
    group = Group()
    busy = Busy(group)

    class HandedOver(List[Any]):
        def remove(self, waiting: Any) -> None:
            busy.end()
            super().remove(waiting)

    group._queue = HandedOver()
    assert group.enter(0.01)
    group.leave()
    assert not group._holder


def test_timed_out_waiter_delays_no_other() -> None:
    group, calls = Group(), []  # type: Any
    busy = Busy(group)
    gives_up = in_thread(group.enter, 0.01)
    gives_up.join(TIMEOUT_S)
    waits = in_thread(Callback(group, lambda: calls.append(1), "").call)
    queued(group, 1)
    busy.end()
    waits.join(TIMEOUT_S)
    assert calls == [1]


@pytest.mark.parametrize("error", [ZeroDivisionError, SystemExit, KeyboardInterrupt])
def test_callback_that_raises_leaves_the_group_and_is_called_again(error: type) -> None:
    group, calls = Group(), []  # type: Any

    def fail() -> None:
        calls.append(1)
        raise error

    for callback in (
        Callback(group, fail, "fail").call,
        CoalescingCallback(group, fail, "fail").trigger,
    ):
        callback()
        callback()
    assert calls == [1, 1, 1, 1]
    assert not group._holder


def test_closed_callback_begins_no_call() -> None:
    group, calls = Group(), []  # type: Any
    callback = Callback(group, lambda: calls.append("callback"), "")
    coalescing = CoalescingCallback(group, lambda: calls.append("work"), "")
    busy = Busy(group)
    waits = in_thread(callback.call)
    queued(group, 1)
    coalescing.trigger()
    callback.close()
    coalescing.close()
    busy.end()
    waits.join(TIMEOUT_S)
    assert calls == []


def test_messages_of_another_thread_wait_for_the_group_one_by_one() -> None:
    heard: List[int] = []
    receiving = SubscriptionCallback(Group(), heard.append, "", batches=False)
    receiving.receive([1, 2, 3], may_wait=True)
    assert heard == [1, 2, 3]


def test_messages_of_this_process_never_wait_and_are_all_delivered() -> None:
    group = Group()
    heard: List[List[int]] = []
    receiving = SubscriptionCallback(group, heard.append, "", batches=True)
    busy = Busy(group)
    receiving.receive([1, 2], may_wait=False)
    receiving.receive([3], may_wait=False)
    assert heard == []
    busy.end()
    assert heard == [[1, 2, 3]]


def test_two_nodes_that_answer_each_other_in_one_process_do_not_wait_for_each_other() -> None:
    groups = Group(), Group()
    heard: List[Any] = [[], []]
    both = threading.Barrier(2, timeout=TIMEOUT_S)

    def send(number: int) -> None:
        both.wait()  # both are in their own groups now
        receivings[1 - number].receive([number], may_wait=False)

    receivings = [
        SubscriptionCallback(group, heard[i].append, "", False) for i, group in enumerate(groups)
    ]
    threads = [in_thread(Callback(groups[i], send, "").call, i) for i in range(2)]
    for thread in threads:
        thread.join(TIMEOUT_S)
    assert heard == [[1], [0]]


def test_reentrant_group_overlaps_itself() -> None:
    group = ReentrantCallbackGroup()
    one, other = Busy(group), Busy(group)
    calls: List[int] = []
    group.offer(lambda: calls.append(1))
    assert calls == [1]
    assert not group.wait_until_left(0.01)
    one.end()
    other.end()
    assert group.wait_until_left(0.0)


def test_closing_a_reentrant_group_does_not_wait_for_the_callers_own_callback() -> None:
    group = ReentrantCallbackGroup()
    left: List[bool] = []
    Callback(group, lambda: left.append(group.wait_until_left(0.0)), "").call()
    assert left == [True]


def test_reentrant_group_is_left_after_both_nested_callbacks() -> None:
    group, inside, once, twice = ReentrantCallbackGroup(), *(threading.Event() for _ in range(3))

    def enter_and_leave() -> None:
        group.enter()
        group.enter()
        inside.set()
        assert once.wait(TIMEOUT_S)
        group.leave()
        inside.set()
        assert twice.wait(TIMEOUT_S)
        group.leave()

    thread = in_thread(enter_and_leave)
    for event in (once, twice):
        assert inside.wait(TIMEOUT_S)
        inside.clear()
        assert not group.wait_until_left(0.01)
        event.set()
    assert group.wait_until_left(TIMEOUT_S)
    thread.join(TIMEOUT_S)


def test_wait_ends_when_a_reentrant_group_is_just_being_left() -> None:
    group = ReentrantCallbackGroup()
    for _ in range(100):
        busy, began = Busy(group), time.monotonic()
        busy.go_on.set()
        assert group.wait_until_left(TIMEOUT_S)
        assert time.monotonic() < began + TIMEOUT_S
        busy.end()
    assert not group._depths and not group._awaiting
