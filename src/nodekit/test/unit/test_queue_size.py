"""Tests of a subscription's queue size without an executor, and of its warning."""

import contextlib
import socket
import struct
from typing import Any, Iterator, List, Optional, Tuple

import pytest
import rospy
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from std_msgs.msg import String

from nodekit import Node, SingleThreadedExecutor
from nodekit.groups.callback_groups import Group
from nodekit.node import callbacks
from nodekit.node.callbacks import SubscriptionCallback
from nodekit.node.names import Names
from nodekit.testing.waiting import in_thread, wait_until

TIMEOUT_S = 20.0
TOPIC = "/queue_size"
#: More than one read of a connection returns.
LONG = 100_000


@pytest.fixture()
def logged(monkeypatch: "pytest.MonkeyPatch") -> List[str]:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: lines.append(text % args))
    return lines


@pytest.fixture()
def now(monkeypatch: "pytest.MonkeyPatch") -> List[float]:
    moment = [100.0]
    monkeypatch.setattr(callbacks.time, "monotonic", lambda: moment[0])
    return moment


def packet(number: int) -> bytes:
    data = str(number).encode().rjust(LONG)
    return struct.pack("<II", 4 + len(data), len(data)) + data


@contextlib.contextmanager
def connection(receive: Any, newest_only: bool) -> Iterator[Tuple[socket.socket, Any]]:
    """Open a subscription and connect a socket in place of a publisher; yield a reading step."""
    with contextlib.ExitStack() as stack:
        node = Node(Names("/one", True))
        stack.callback(node.close)
        subscription = node.create_subscription(
            TOPIC, String, receive, queue_size=1 if newest_only else None
        )
        subscription.open()
        stack.callback(subscription.close)
        topic: Any = subscription._subscriber.impl  # type: ignore[union-attr]
        ours, theirs = (stack.enter_context(end) for end in socket.socketpair())
        theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 20 * LONG)
        transport = TCPROSTransport(TCPROSSub(TOPIC, String, None), TOPIC)
        transport.set_socket(ours, "/publisher")
        stack.callback(transport.close)
        topic.add_connection(transport)
        yield theirs, lambda: topic.receive_callback(transport.receive_once(), transport)


def fill(theirs: socket.socket) -> List[int]:
    """Send whole messages until the socket is full; return their numbers."""
    numbers: List[int] = []
    theirs.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        while True:
            rest = packet(len(numbers))
            if theirs.send(rest) != len(rest):
                break
            numbers.append(len(numbers))
    return numbers


def test_queue_size_one_without_executor_receives_the_newest_in_the_connection() -> None:
    heard: List[int] = []
    with connection(lambda message: heard.append(int(message.data)), True) as (theirs, receive):
        sent = fill(theirs)
        assert len(sent) > 1, "the socket must hold several messages"
        receive()
    assert heard == sent[-1:]


def test_no_queue_size_without_executor_receives_every_message() -> None:
    heard: List[int] = []
    with connection(lambda message: heard.append(int(message.data)), False) as (theirs, receive):
        sent = fill(theirs)
        while len(heard) < len(sent):
            receive()
    assert heard == sent


def receiving(group: Group, heard: List[Any], queue_size: Optional[int]) -> SubscriptionCallback:
    return SubscriptionCallback(group, heard.append, TOPIC, False, queue_size)


@pytest.mark.parametrize("may_wait", [True, False], ids=["other process", "same process"])
@pytest.mark.parametrize("queue_size, expected", [(1, [9]), (3, [7, 8, 9])])
def test_queue_size_without_executor_passes_on_the_newest_of_a_batch(
    may_wait: bool, queue_size: int, expected: List[int]
) -> None:
    heard: List[int] = []
    receiving(Group(), heard, queue_size).receive(list(range(10)), may_wait)
    assert heard == expected


@pytest.mark.parametrize("queue_size", [None, -1])
def test_unlimited_queue_without_executor_passes_on_every_message(
    queue_size: Optional[int],
) -> None:
    heard: List[int] = []
    receiving(Group(), heard, queue_size).receive(list(range(50)), True)
    assert heard == list(range(50))


@pytest.mark.parametrize("may_wait", [True, False], ids=["other process", "same process"])
def test_queue_size_with_busy_group_keeps_the_newest_of_later_messages(may_wait: bool) -> None:
    group, heard = Group(), []  # type: Group, List[int]
    callback = receiving(group, heard, 2)
    with group:
        for number in range(5):
            in_thread(callback.receive, [number], may_wait).join(TIMEOUT_S)
        assert heard == []
    wait_until(lambda: heard == [3, 4], lambda: str(heard))


def test_message_that_waits_in_a_batch_is_warned_of_once_with_its_age(
    logged: List[str], now: List[float]
) -> None:
    def take_time(_message: Any) -> None:
        now[0] += 0.4

    slow = SubscriptionCallback(Group(), take_time, TOPIC, False)
    slow.receive(list(range(10)), True)
    slow.receive(list(range(10)), True)
    assert logged == [
        f"{TOPIC}: messages wait for their callback (1.2 s); shorten the callbacks of its group, "
        "or set queue_size=1 to receive only the newest"
    ]


def test_message_that_waits_for_its_group_is_warned_of(logged: List[str], now: List[float]) -> None:
    group, heard = Group(), []  # type: Group, List[int]
    callback = receiving(group, heard, None)
    with group:
        callback.receive([1], False)
        now[0] += 2.5
    assert heard == [1]
    assert len(logged) == 1 and "messages wait for their callback (2.5 s)" in logged[0]


def test_message_that_waits_for_an_executor_is_warned_of(
    logged: List[str], now: List[float]
) -> None:
    heard: List[int] = []
    executor = SingleThreadedExecutor()
    callback = receiving(Group(), heard, None)
    callback.attach(executor._ready)
    with callback.group:
        callback.receive([1, 2], True)
        now[0] += 3.0
    assert executor.shutdown(TIMEOUT_S)
    assert heard == [1, 2]
    assert len(logged) == 1 and "messages wait for their callback (3.0 s)" in logged[0]


def test_prompt_messages_are_not_warned_of(logged: List[str]) -> None:
    heard: List[int] = []
    callback = receiving(Group(), heard, None)
    for number in range(100):
        callback.receive([number], True)
    assert heard == list(range(100)) and logged == []


def test_message_newer_than_those_dropped_has_not_waited_as_long(
    logged: List[str], now: List[float]
) -> None:
    group, heard = Group(), []  # type: Group, List[int]
    callback = receiving(group, heard, 1)
    with group:
        callback.receive([1], False)
        now[0] += 1.5
        callback.receive([2], False)
    assert heard == [2]
    assert logged == []
