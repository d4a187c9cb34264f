"""Raw subscriptions, with a socket in place of a publisher and no master."""

import contextlib
import socket
import struct
import tracemalloc
from typing import Iterator, List
from unittest import mock

import pytest
import rospy
from rospy.impl.registration import get_topic_manager
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE, TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from std_msgs.msg import Float32

from topic_scope.controls.node_status import NodeStatuses
from topic_scope.sampling.message_source import TICK_NS
from topic_scope.sampling.raw_subscriptions import RawSubscription, RawSubscriptions, SteadyClock
from topic_scope.timing.nanoseconds import to_ns

TOPIC, OTHER = "/topic", "/other"


def packet(number: float) -> bytes:
    return struct.pack("<If", 4, number)


class Connection:
    """Connection of the process to a publisher of the topic."""

    def __init__(self, stack: contextlib.ExitStack, name: str = "/publisher") -> None:
        ours, self.socket = (stack.enter_context(end) for end in socket.socketpair())
        self.transport = TCPROSTransport(TCPROSSub(TOPIC, rospy.AnyMsg), TOPIC)
        self.transport.set_socket(ours, name)
        self.transport.header = {"type": "std_msgs/Float32"}
        stack.callback(self.transport.close)
        self._topic = get_topic_manager().get_subscriber_impl(TOPIC)
        self._topic.add_connection(self.transport)

    def bring(self, *numbers: float) -> None:
        self.receive(b"".join(map(packet, numbers)))

    def receive(self, data: bytes) -> None:
        """Deliver data as the thread of a connection does."""
        self.socket.sendall(data)
        self._topic.receive_callback(self.transport.receive_once(), self.transport)


def test_steady_clock_tolerates_an_interruption_between_readings() -> None:
    now = [1000.0]
    interruptions = iter([0.3, 0.2])

    def read() -> float:
        """Return the time of one clock; time may pass before the other is read."""
        before = now[0]
        now[0] += next(interruptions, 0.0)
        return before

    with mock.patch("time.time_ns", lambda: to_ns(read())), mock.patch(
        "time.monotonic_ns", lambda: to_ns(now[0] - 900.0)
    ):
        assert SteadyClock().now() == pytest.approx(now[0])


@pytest.fixture
def stack() -> Iterator[contextlib.ExitStack]:
    with contextlib.ExitStack() as stack:
        yield stack


@pytest.fixture
def subscription(stack: contextlib.ExitStack) -> RawSubscription:
    return opened(stack)


def opened(stack: contextlib.ExitStack) -> RawSubscription:
    subscription = RawSubscription(TOPIC, SteadyClock())
    stack.callback(subscription.close)
    return subscription


def test_messages_are_returned_unchanged(
    subscription: RawSubscription, stack: contextlib.ExitStack
) -> None:
    connection = Connection(stack)
    connection.bring(1.0, 2.0)
    connection.bring(3.0)
    (batch,) = subscription.drain()
    assert batch.header == {"type": "std_msgs/Float32"}
    assert batch.messages == [packet(number)[4:] for number in (1.0, 2.0, 3.0)]
    assert list(batch.times) == sorted(set(batch.times)), "no two at one time"
    assert subscription.drain() == []


def test_later_subscription_gets_latched_messages(
    subscription: RawSubscription, stack: contextlib.ExitStack
) -> None:
    connection = Connection(stack)
    connection.transport.is_latched = True
    connection.bring(1.0)
    (batch,) = opened(stack).drain()
    assert batch.messages == [packet(1.0)[4:]]


def test_queued_messages_take_little_memory(
    subscription: RawSubscription, stack: contextlib.ExitStack
) -> None:
    connection = Connection(stack)
    tracemalloc.start()
    try:
        connection.bring(1.0)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < DEFAULT_BUFF_SIZE / 4


def test_messages_of_two_publishers_are_separate(
    subscription: RawSubscription, stack: contextlib.ExitStack
) -> None:
    one, other = Connection(stack, "/one"), Connection(stack, "/other")
    one.bring(1.0)
    other.bring(2.0)
    one.bring(3.0, 4.0)
    batches = subscription.drain()
    assert [batch.header for batch in batches] == [
        connection.transport.header for connection in (one, other, one)
    ]
    assert [len(batch.messages) for batch in batches] == [1, 1, 2]


@pytest.mark.parametrize("kind, heard", [("String", ["idle"]), ("Float32", [])])
def test_raw_and_usual_subscriptions_coexist(
    subscription: RawSubscription, stack: contextlib.ExitStack, kind: str, heard: List[str]
) -> None:
    send = mock.Mock()
    own = RawSubscriptions(SteadyClock())
    statuses = NodeStatuses(own, mock.Mock(), send)
    statuses.follow({"/node": TOPIC})
    stack.callback(own.adjust)
    stack.callback(own.want, [])
    own.adjust()
    connection = Connection(stack)
    connection.transport.header = {"type": "std_msgs/" + kind}
    connection.receive(struct.pack("<II", 8, 4) + b"idle")
    statuses.update()
    assert [call[0][0]["nodes"]["/node"] for call in send.call_args_list] == heard
    assert len(subscription.drain()[0].messages) == 1


def test_messages_that_arrive_together_have_different_times(
    subscription: RawSubscription, stack: contextlib.ExitStack
) -> None:
    with mock.patch.object(SteadyClock, "now_ns", return_value=10**18):
        Connection(stack).bring(1.0, 2.0, 3.0)
    (batch,) = subscription.drain()
    assert list(batch.times) == [10**18, 10**18 + TICK_NS, 10**18 + 2 * TICK_NS]


def test_queue_is_bounded(subscription: RawSubscription, stack: contextlib.ExitStack) -> None:
    connection = Connection(stack)
    tracemalloc.start()
    try:
        for _ in range(100):
            connection.bring(*range(100))
        most, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 100 * 100 * 100
    with mock.patch("topic_scope.sampling.raw_subscriptions.WAITING", most), mock.patch(
        "rospy.logwarn"
    ) as log:
        for _ in range(200):
            connection.bring(*range(100))
        (batch,) = subscription.drain()
        connection.bring(1.0)  # there is room again
        assert [len(one.messages) for one in subscription.drain()] == [1]
    assert 10000 < len(batch.messages) < 30000
    text, *values = log.call_args[0]
    assert f"{TOPIC} is too fast" in text % tuple(values)


def test_subscription_of_another_type_does_not_block(
    stack: contextlib.ExitStack,
) -> None:
    subscriptions = RawSubscriptions(SteadyClock())
    stack.callback(subscriptions.adjust)
    stack.callback(subscriptions.want, [])
    rival = rospy.Subscriber(TOPIC, Float32)
    subscriptions.want([TOPIC, OTHER])
    with mock.patch("rospy.logwarn") as log:
        subscriptions.adjust()
    assert set(subscriptions.subscriptions()) == {OTHER}
    assert TOPIC in str(log.call_args[0][1])
    rival.unregister()
    subscriptions.adjust()
    assert set(subscriptions.subscriptions()) == {TOPIC, OTHER}
