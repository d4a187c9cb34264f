"""Tests of the ready queue of an executor: with a model, and each rule."""

import itertools
import random
import threading
import time
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple, Type

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodekit.groups.callback_groups import CallbackGroup, Group, ReentrantCallbackGroup
from nodekit.groups.ready_queue import CallQueue, ReadyCall, ReadyQueue

WORKERS = 3
DEPTH = 3


class Modelled:
    """A call queue, and a simple model of it."""

    def __init__(self, ready: ReadyQueue, group: CallbackGroup, together: bool = False) -> None:
        self.group, self.together = group, together
        self.run: List[Any] = []
        self.dropped: List[Any] = []
        self.calls = CallQueue(ready, group, DEPTH, self.run.extend, self.dropped.append, together)
        self.waiting: List[Any] = []
        self.expected_run: List[Any] = []
        self.expected_dropped: List[Any] = []
        self.asks = False


class World:
    """A ready queue with workers, driven step by step by one thread; each step is checked."""

    def __init__(self) -> None:
        self.ready = ReadyQueue()
        shared, urgent, free = Group(), Group(urgent=True), ReentrantCallbackGroup()
        self.queues = [
            Modelled(self.ready, shared),
            Modelled(self.ready, shared, together=True),
            Modelled(self.ready, Group()),
            Modelled(self.ready, urgent),
            Modelled(self.ready, free),
        ]
        self.things = itertools.count()
        self.turns: List[Tuple[Modelled, ReadyCall]] = []
        self.standing: Deque[Modelled] = deque()
        self.asking: Dict[CallbackGroup, Deque[Modelled]] = {}
        self.kept: List[CallbackGroup] = []

    def ask(self, one: Modelled) -> None:
        if one.asks or not one.waiting:
            return
        one.asks = True
        if isinstance(one.group, ReentrantCallbackGroup):
            self.standing.append(one)
        elif one.group in self.kept:
            self.asking.setdefault(one.group, deque()).append(one)
        else:
            self.kept.append(one.group)
            self.standing.append(one)

    def put(self, number: int) -> None:
        one = self.queues[number % len(self.queues)]
        thing = next(self.things)
        one.calls.put(thing)
        if len(one.waiting) == DEPTH:
            one.expected_dropped.append(one.waiting.pop(0))
        one.waiting.append(thing)
        self.ask(one)

    def next_call(self) -> None:
        if len(self.turns) == WORKERS:
            return
        turn = self.ready.next_call(wait=False)
        urgent = [one for one in self.standing if one.group.urgent]
        expected = (urgent or list(self.standing) or [None])[0]
        assert (turn and turn.calls) is (expected and expected.calls)
        if turn is None or expected is None:
            return
        self.standing.remove(expected)
        count = len(expected.waiting) if expected.together else 1
        assert turn.things == expected.waiting[:count]
        del expected.waiting[:count]
        expected.asks = False
        self.ask(expected)
        self.turns.append((expected, turn))

    def finish(self, number: int) -> None:
        if not self.turns:
            return
        one, turn = self.turns.pop(number % len(self.turns))
        self.ready.make_call(turn)
        one.expected_run += turn.things
        if isinstance(one.group, ReentrantCallbackGroup):
            return
        others = self.asking.get(one.group)
        if others:
            self.standing.append(others.popleft())
        else:
            self.kept.remove(one.group)

    def check(self) -> None:
        for one in self.queues:
            assert one.run == one.expected_run
            assert one.dropped == one.expected_dropped
            assert one.calls.waiting == len(one.waiting)
            assert one.calls.dropped == len(one.dropped)

    def go(self, steps: List[int]) -> None:
        for step in steps:
            what, number = step % 3, step // 3
            if what == 0:
                self.put(number)
            elif what == 1:
                self.next_call()
            else:
                self.finish(number)
            self.check()

    def end(self) -> None:
        """Bring all that waits to its end: nothing may be left standing."""
        while self.turns or self.standing:
            self.next_call()
            self.finish(0)
        self.check()
        assert not any(one.waiting for one in self.queues)
        assert self.ready.close(0.0)


@settings(deadline=None, max_examples=200)
@given(st.lists(st.integers(0, 29), max_size=60))
def test_queue_is_as_the_model_says(steps: List[int]) -> None:
    world = World()
    world.go(steps)
    world.end()


def test_two_thousand_schedules() -> None:
    chance = random.Random(15)
    for _ in range(2_000):
        world = World()
        world.go([chance.randrange(30) for _ in range(12)])
        world.end()


def served(ready: ReadyQueue) -> Optional[CallQueue]:
    """Make the next call; return its queue."""
    turn = ready.next_call(wait=False)
    if turn is None:
        return None
    ready.make_call(turn)
    return turn.calls


def make(ready: ReadyQueue, group: Optional[CallbackGroup] = None, depth: int = 10) -> CallQueue:
    return CallQueue(ready, group or Group(), depth, lambda things: None, lambda thing: None)


def test_ten_slow_messages_do_not_keep_a_timer_from_its_turns() -> None:
    ready = ReadyQueue()
    slow, timer = make(ready), make(ready)
    for number in range(10):
        slow.put(number)
    order = []
    for _ in range(10):
        timer.put("tick")
        order += [served(ready), served(ready)]
    assert order == [slow, timer] * 10


def test_calls_in_a_reentrant_group_overlaps_itself_and_lets_others_in_between() -> None:
    ready = ReadyQueue()
    group = ReentrantCallbackGroup()
    one, other = make(ready, group), make(ready, group)
    for number in range(3):
        one.put(number)
    other.put(0)
    turns = [ready.next_call(wait=False) for _ in range(4)]
    assert [turn and turn.calls for turn in turns] == [one, other, one, one]
    assert one.running == 3


def test_group_that_somebody_else_is_in_keeps_only_its_own_calls_out() -> None:
    ready = ReadyQueue()
    group = Group()
    kept_out, free = make(ready, group), make(ready)
    with group:
        kept_out.put(1)
        free.put(1)
        assert served(ready) is free
        assert ready.next_call(wait=False) is None
    assert served(ready) is kept_out
    assert not group._inside.locked()


@pytest.mark.parametrize("kind", [Group, ReentrantCallbackGroup])
def test_closed_queue_drops_the_rest_and_frees_the_groups(kind: Type[CallbackGroup]) -> None:
    ready = ReadyQueue()
    group: Any = kind()
    given_up: List[int] = []
    queues = [CallQueue(ready, group, 700, lambda things: None, given_up.append) for _ in range(3)]
    for thing in range(700):  # more than there may be calls within each other
        for calls in queues:
            calls.put(thing)
    under_way = ready.next_call(wait=False)
    assert under_way is not None
    assert not ready.close(0.0)
    ready.make_call(under_way)
    assert sorted(given_up) == [thing for thing in range(700) for _ in queues]
    assert group.wait_until_left(0.0)
    assert not (group._inside.locked() if isinstance(group, Group) else group._depths)
    queues[0].put(700)
    assert given_up[-1] == 700 and queues[0].dropped == 1
    assert ready.next_call() is None


def test_line_shows_durations_and_waits_of_calls() -> None:
    ready = ReadyQueue()
    calls = CallQueue(ready, Group(), 10, lambda things: None, lambda thing: None, together=True)
    assert calls.longest == calls.longest_wait == 0.0
    calls.put(1)
    time.sleep(0.02)
    calls.put(2)
    served(ready)
    assert calls.made == 1 and calls.running == 0
    assert 0.02 <= calls.longest_wait < 10.0 and 0.0 <= calls.longest < 10.0


def test_line_knows_whether_the_caller_is_all_it_has() -> None:
    ready = ReadyQueue()
    assert not ready.is_served_by_caller_alone()
    ready.workers.add(threading.current_thread())
    assert ready.is_served_by_caller_alone()
    ready.workers.add(threading.Thread())
    assert not ready.is_served_by_caller_alone()
