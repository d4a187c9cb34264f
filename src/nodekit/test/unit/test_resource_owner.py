"""Tests of resource owners: closing, also while other threads add or close resources."""

import contextlib
import threading
from typing import Any, Iterable, Iterator, List

import pytest
import rospy

from nodekit import Node
from nodekit.node.names import Names
from nodekit.node.resource_owner import Closed, ResourceOwner
from nodekit.node.start_queue import StartQueue


class Thing:
    """Notes whether it was closed."""

    def __init__(self) -> None:
        self.closed = False

    def close(self) -> None:
        self.closed = True


class Interrupted(List[Any]):
    """List that lets another thread run after its last element, unless a lock prevents it."""

    def __init__(self, things: Iterable[Any], other: threading.Thread) -> None:
        super().__init__(things)
        self._other = other

    def __iter__(self) -> Iterator[Any]:
        yield from super().__iter__()
        self._other.start()
        self._other.join(0.1)


def test_object_created_during_a_close_is_closed_with_the_rest() -> None:
    owner, gone, late = ResourceOwner(StartQueue()), Thing(), Thing()
    other = threading.Thread(target=owner.own, args=(late,))
    owner._owned = Interrupted([gone], other)
    owner.disown(gone)
    other.join()
    owner.close()
    assert (late.closed, gone.closed) == (True, False)


def test_the_latest_is_closed_first_also_within_a_scope() -> None:
    closed: List[str] = []
    node = Node(Names("/whole", True))
    part = node.create_scope()
    for owner, name in ((node, "second"), (part, "first"), (part, "first too"), (node, "third")):
        owner.own(contextlib.ExitStack()).callback(closed.append, name)
    node.close()
    assert closed == ["third", "second", "first too", "first"]


@pytest.mark.parametrize("fails", ["start", "own"])
def test_hosted_node_that_cannot_start_leaves_nothing(
    fails: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    node = Node(Names("/whole", True))
    node.start()
    things: List[Thing] = []

    def guest(hosted: Node) -> None:
        things.append(hosted.own(Thing()))
        if fails == "own":
            node.close()

    def start(_hosted: Node) -> None:
        if fails == "start":
            raise rospy.ROSException("on purpose")

    monkeypatch.setattr(Node, "start", start)
    with pytest.raises(Closed if fails == "own" else rospy.ROSException):
        node.host("part", "/space", guest)
    assert [thing.closed for thing in things] == [True]
