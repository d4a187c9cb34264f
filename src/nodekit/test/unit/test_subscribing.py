"""The subscriber inside rospy's own objects, with sockets in place of publishers and no master."""

import contextlib
import socket
import struct
import threading

import pytest
import rospy
import rospy.topics
from hypothesis import given
from hypothesis import strategies as st
from rospy.exceptions import TransportException, TransportTerminated
from rospy.impl.registration import get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from std_msgs.msg import Float32, String

from nodekit.messaging.publisher import Publisher
from nodekit.messaging.subscriber import Subscriber
from nodekit.rospy_internals import subscribers

TOPIC = "/topic"
TIME_OUT = 20.0  # s


class Publisherless:
    """A subscriber with one connection, whose other end is a socket."""

    def __init__(self, stack, make=Subscriber):
        self.batches = []
        self.subscriber = make(TOPIC, String, self.batches.append)
        stack.callback(self.subscriber.unregister)
        ours, self.socket = (stack.enter_context(end) for end in socket.socketpair())
        self.transport = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
        self.transport.set_socket(ours, "/publisher")
        stack.callback(self.transport.close)
        self.subscriber.impl.add_connection(self.transport)

    def receive_all(self):
        """Do what the thread of a connection does, with all that has been sent."""
        self.socket.shutdown(socket.SHUT_WR)
        self.receive_until_closed()

    def receive_until_closed(self):
        with pytest.raises(TransportTerminated):
            while True:
                messages = self.transport.receive_once()
                self.subscriber.impl.receive_callback(messages, self.transport)

    @property
    def words(self):
        return [message.data for batch in self.batches for message in batch]


@pytest.fixture
def connected():
    with contextlib.ExitStack() as stack:
        yield Publisherless(stack)


def packet(word):
    data = word.encode()
    return struct.pack("<II", 4 + len(data), len(data)) + data


def test_this_rospy_is_known():
    subscribers.subscriber_mismatch.cache_clear()
    assert subscribers.subscriber_mismatch() == ""


@pytest.mark.parametrize("part", ["_SUBSCRIBER_ATTRIBUTES", "_TRANSPORT_ATTRIBUTES"])
def test_missing_attribute_is_recognised(monkeypatch, part):
    subscribers.subscriber_mismatch.cache_clear()
    monkeypatch.setattr(subscribers, part, "close something_else")
    assert "something_else" in subscribers.subscriber_mismatch()
    subscribers.subscriber_mismatch.cache_clear()


def test_absent_internals_are_recognised(monkeypatch):
    subscribers.subscriber_mismatch.cache_clear()
    monkeypatch.delattr(rospy.topics._SubscriberImpl, "receive_callback")
    assert subscribers.subscriber_mismatch() != ""
    subscribers.subscriber_mismatch.cache_clear()


@given(st.lists(st.text(max_size=20), min_size=1, max_size=20), st.data())
def test_messages_are_whole_and_in_order_however_they_arrive(words, data):
    stream = b"".join(packet(word) for word in words)
    with contextlib.ExitStack() as stack:
        connected = Publisherless(stack)
        receiver = threading.Thread(target=connected.receive_until_closed)
        position = 0
        while position < len(stream):
            size = data.draw(st.integers(1, len(stream) - position))
            connected.socket.sendall(stream[position : position + size])
            position += size
            if position == size:
                receiver.start()
        connected.socket.shutdown(socket.SHUT_WR)
        receiver.join(TIME_OUT)
        assert connected.words == words


def test_what_arrives_together_is_handed_over_together(connected):
    connected.socket.sendall(packet("one") + packet("two") + packet("three")[:5])
    connected.socket.sendall(packet("three")[5:])
    connected.receive_all()
    assert [[message.data for message in batch] for batch in connected.batches] == [
        ["one", "two", "three"]
    ]
    assert connected.transport.stat_num_msg == 3
    assert connected.transport.stat_bytes == len(packet("one") + packet("two") + packet("three"))


def test_a_message_longer_than_any_read_arrives(connected):
    word = "long" * 1_000_000
    sender = threading.Thread(
        target=lambda: (connected.socket.sendall(packet(word)), connected.socket.close())
    )
    sender.start()
    connected.receive_until_closed()
    sender.join(TIME_OUT)
    assert connected.words == [word]


def test_what_came_with_the_header_is_not_lost(connected):
    connected.transport.read_buff.write(packet("early")[:6])
    connected.socket.sendall(packet("early")[6:] + packet("later"))
    connected.receive_all()
    assert connected.words == ["early", "later"]


def test_a_new_connection_begins_with_a_new_message(connected):
    connected.socket.sendall(packet("whole") + packet("torn")[:6])
    connected.receive_all()
    ours, theirs = socket.socketpair()
    with ours, theirs:
        connected.transport.socket = ours
        theirs.sendall(packet("again"))
        assert [message.data for message in connected.transport.receive_once()] == ["again"]
    assert connected.words == ["whole"]


def test_nonsense_ends_the_connection_as_rospy_expects_it(connected):
    connected.socket.sendall(struct.pack("<IH", 2, 7))
    with pytest.raises(TransportException):
        connected.transport.receive_once()


def test_latched_message_is_kept_for_callbacks_that_come_later(connected):
    connected.transport.is_latched = True
    connected.socket.sendall(packet("old") + packet("last"))
    connected.receive_all()
    assert connected.transport.latch.data == "last"


def test_a_defect_of_one_callback_leaves_the_others_alone(connected):
    def fail(messages):
        raise ValueError("defect")

    topic = connected.subscriber.impl
    subscribers.receive_in_batches(TOPIC, String, fail)
    late = []
    subscribers.receive_in_batches(TOPIC, String, late.extend)
    connected.socket.sendall(packet("news"))
    connected.receive_all()
    assert connected.words == ["news"]
    assert [message.data for message in late] == ["news"]
    assert topic is get_topic_manager().get_subscriber_impl(TOPIC)


def test_a_plain_subscriber_of_the_same_topic_hears_the_same(connected):
    plain = []
    second = rospy.Subscriber(TOPIC, String, plain.append)
    connected.socket.sendall(packet("one") + packet("two"))
    connected.receive_all()
    second.unregister()
    assert connected.words == ["one", "two"]
    assert [message.data for message in plain] == ["one", "two"]


@pytest.mark.parametrize("known", [True, False])
def test_where_batches_are_not_possible_messages_come_one_by_one(monkeypatch, known):
    with contextlib.ExitStack() as stack:
        if known:
            stack.callback(rospy.Subscriber(TOPIC, String).unregister)
        else:
            monkeypatch.setattr(subscribers, "subscriber_mismatch", lambda: "all is different")
        connected = Publisherless(stack)
        connected.socket.sendall(packet("one") + packet("two"))
        connected.receive_all()
        assert [len(batch) for batch in connected.batches] == [1, 1]
        assert connected.words == ["one", "two"]


def test_batch_that_is_published_arrives_whole_and_is_counted():
    with contextlib.ExitStack() as stack:
        publisher = Publisher(TOPIC, String)
        stack.callback(publisher.unregister)
        ours, theirs = (stack.enter_context(end) for end in socket.socketpair())
        transport = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
        transport.set_socket(ours, "/subscriber")
        publisher.impl.add_connection(transport)
        publisher.publish_all([])
        publisher.publish_all([String("one"), String("two")])
        expected = packet("one") + packet("two")
        assert theirs.recv(len(expected) + 1) == expected
        assert [(s.sent, s.lost) for s in publisher.statistics()] == [(2, 0)]
        transport.close()


@pytest.fixture
def together():
    """A publisher and a subscriber of the same topic in the same process."""
    with contextlib.ExitStack() as stack:
        batches = []
        subscriber = Subscriber(TOPIC, String, batches.append)
        stack.callback(subscriber.unregister)
        publisher = Publisher(TOPIC, String, latch=True)
        stack.callback(publisher.unregister)
        yield publisher, subscriber, batches


def test_subscriber_of_the_same_process_hears_without_a_connection(together, monkeypatch):
    publisher, subscriber, batches = together
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    assert subscriber.impl.has_connection("http://here")
    assert not subscriber.impl.has_connection("http://elsewhere")
    sent = [String("one"), String("two")]
    publisher.publish_all(sent)
    publisher.publish(String("three"))
    assert [[message.data for message in batch] for batch in batches] == [["one", "two"], ["three"]]
    assert batches[0][0] is not sent[0], "each side has a message of its own"
    assert batches[0][0]._connection_header["topic"] == TOPIC


def test_numbers_are_rounded_as_for_any_other_subscriber():
    with contextlib.ExitStack() as stack:
        heard = []
        stack.callback(Subscriber(TOPIC, Float32, heard.extend).unregister)
        publisher = Publisher(TOPIC, Float32)
        stack.callback(publisher.unregister)
        publisher.publish(Float32(0.1))
        assert [message.data for message in heard] == [struct.unpack("<f", b"\xcd\xcc\xcc=")[0]]


def test_late_subscriber_of_the_same_process_gets_the_latched_message(together):
    publisher, _, batches = together
    publisher.publish(String("last"))
    late = []
    second = Subscriber(TOPIC, String, late.extend)
    assert [message.data for message in late] == ["last"]
    assert len(batches) == 1
    second.unregister()


def test_subscriber_that_publishes_in_turn_is_not_in_its_own_way(together):
    publisher, subscriber, batches = together

    def answer(messages):
        if messages[0].data != "answer":
            other = threading.Thread(target=publisher.publish, args=(String("answer"),))
            other.start()
            other.join(TIME_OUT)

    subscribers.receive_in_batches(TOPIC, String, answer)
    publisher.publish(String("question"))
    assert [message.data for batch in batches for message in batch] == ["question", "answer"]


def test_publisher_that_has_gone_is_heard_no_more(together, monkeypatch):
    publisher, subscriber, batches = together
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    publisher.unregister()
    assert not subscriber.impl.has_connection("http://here")
    plain = rospy.Publisher(TOPIC, String, queue_size=10)
    assert not subscriber.impl.has_connection("http://here"), "a plain one needs a connection"
    plain.unregister()
