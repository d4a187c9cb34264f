"""Tests of the state that the nodes of a process share."""

import contextlib
import gc
import threading
from typing import List

import pytest

from nodekit.process_context import ProcessContext
from nodekit.testing.waiting import TIMEOUT_S, in_thread


class Shared:
    """Any class."""


def test_object_of_a_class_is_created_once_by_many_threads() -> None:
    context, created = ProcessContext(), []
    second_creation = threading.Barrier(2)
    found: List[Shared] = []

    def create() -> Shared:
        created.append(Shared())
        with contextlib.suppress(threading.BrokenBarrierError):  # the creation is the only one
            second_creation.wait(0.2)
        return created[-1]

    def ask() -> None:
        found.append(context.get(Shared, create))

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(created) == 1
    assert len(found) == 8 and set(found) == set(created)


def test_handler_that_interrupts_a_creation_gets_the_same_object() -> None:
    context, inside = ProcessContext(), []

    def create() -> Shared:
        inside.append(context.get(Shared))  # as a signal handler, in the same thread
        return Shared()

    created = in_thread(lambda: inside.append(context.get(Shared, create)))
    created.join(TIMEOUT_S)
    assert len(inside) == 2 and inside[0] is inside[1]


def test_objects_of_a_class_are_distinguished_by_name() -> None:
    context = ProcessContext()
    assert context.get(Shared, name="a") is context.get(Shared, name="a")
    assert context.get(Shared, name="a") is not context.get(Shared, name="b")


def test_creation_that_fails_is_tried_again() -> None:
    context = ProcessContext()

    def fail() -> Shared:
        raise ConnectionError("the master does not answer")

    with pytest.raises(ConnectionError):
        context.get(Shared, fail)
    assert context.find(Shared) is None
    assert isinstance(context.get(Shared), Shared)


def test_creation_may_use_other_objects_and_does_not_delay_them() -> None:
    """A watcher's creation waits for the master; other threads create timers meanwhile."""
    context = ProcessContext()

    def create() -> List[str]:
        other = threading.Thread(target=context.get, args=(Shared,))
        other.start()
        other.join(10)
        return [type(context.get(Shared)).__name__] if not other.is_alive() else []

    assert context.get(list, create) == ["Shared"]


def test_closed_objects_leave_the_sets_of_the_process() -> None:
    context, kept, dropped = ProcessContext(), Shared(), Shared()
    context.instances(Shared).update((kept, dropped))
    context.by_name(Shared).update(kept=kept, dropped=dropped)
    del dropped
    gc.collect()
    assert list(context.instances(Shared)) == [kept]
    assert dict(context.by_name(Shared)) == {"kept": kept}


def test_numbers_are_unique_for_a_class() -> None:
    context = ProcessContext()
    assert [context.next_number(cls) for cls in (Shared, list, Shared)] == [1, 1, 2]
