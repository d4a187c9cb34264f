"""Tests of the subscribed topic, with sockets in place of publishers and without a master."""

import contextlib
import gc
import os
import socket
import struct
import threading
import time
import tracemalloc

import pytest
import rospy
import rospy.impl.tcpros_base
import rospy.topics
from hypothesis import given
from hypothesis import strategies as st
from rosgraph.network import write_ros_handshake_header
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.registration import get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from std_msgs.msg import Float32, String

from nodekit.messaging.publisher import Publisher
from nodekit.messaging.subscription import LatestMessage, Subscription
from nodekit.rospy_internals import incoming_topic, latched, registration_listener
from nodekit.testing.waiting import wait_until

TOPIC = "/topic"
TIME_OUT = 20.0  # s
#: The float32 next to 0.1.
(ROUNDED,) = struct.unpack("<f", b"\xcd\xcc\xcc=")


class Recorder:
    """An open subscription that records its messages."""

    def __init__(self, stack, data_class=String):
        self.batches = []
        self.may_wait = []
        self.subscription = Subscription(TOPIC, data_class, self.receive)
        stack.callback(self.subscription.close)
        self.subscription.open()

    def receive(self, messages, may_wait):
        self.batches.append(messages)
        self.may_wait.append(may_wait)

    @property
    def impl(self):
        """Rospy's object behind the subscription."""
        return self.subscription._subscriber.impl

    @property
    def words(self):
        return [message.data for batch in self.batches for message in batch]


class Publisherless(Recorder):
    """A subscription with one connection to a socket of the test."""

    def __init__(self, stack):
        super().__init__(stack)
        self.connect(stack)

    def connect(self, stack):
        """Have a connection, from now on in place of the one before."""
        ours, self.socket = (stack.enter_context(end) for end in socket.socketpair())
        protocol = TCPROSSub(TOPIC, String, self.impl.queue_size)  # as rospy makes it
        self.transport = TCPROSTransport(protocol, TOPIC)
        self.transport.set_socket(ours, "/publisher")
        stack.callback(self.transport.close)
        self.topic = self.impl
        self.topic.add_connection(self.transport)

    def receive_all(self):
        """Process all sent data like the thread of a connection."""
        self.socket.shutdown(socket.SHUT_WR)
        self.receive_until_closed()

    def receive_some(self):
        self.topic.receive_callback(self.transport.receive_once(), self.transport)

    def receive_until_closed(self):
        with pytest.raises(TransportTerminated):
            while True:
                self.receive_some()
        self.transport.close()  # as the end of rospy's loop does


@pytest.fixture
def connected():
    with contextlib.ExitStack() as stack:
        yield Publisherless(stack)


def packet(word):
    data = word.encode()
    return struct.pack("<II", 4 + len(data), len(data)) + data


def test_this_rospy_is_known():
    incoming_topic.subscriber_mismatch.cache_clear()
    assert incoming_topic.subscriber_mismatch() == ""


@pytest.mark.parametrize("part", ["_SUBSCRIBER_ATTRIBUTES", "_TRANSPORT_ATTRIBUTES"])
def test_missing_attribute_is_recognised(monkeypatch, part):
    incoming_topic.subscriber_mismatch.cache_clear()
    monkeypatch.setattr(incoming_topic, part, "close something_else")
    assert "something_else" in incoming_topic.subscriber_mismatch()
    incoming_topic.subscriber_mismatch.cache_clear()


def test_absent_internals_are_recognised(monkeypatch):
    incoming_topic.subscriber_mismatch.cache_clear()
    monkeypatch.delattr(rospy.topics._SubscriberImpl, "receive_callback")
    assert incoming_topic.subscriber_mismatch() != ""
    incoming_topic.subscriber_mismatch.cache_clear()


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


def test_messages_that_arrive_together_are_delivered_together(connected):
    connected.socket.sendall(packet("one") + packet("two") + packet("three")[:5])
    connected.socket.sendall(packet("three")[5:])
    connected.receive_all()
    assert [[message.data for message in batch] for batch in connected.batches] == [
        ["one", "two", "three"]
    ]
    assert connected.transport.stat_num_msg == 3
    assert connected.transport.stat_bytes == len(packet("one") + packet("two") + packet("three"))


def test_message_in_two_reads_is_delivered_once(connected):
    halves = packet("first")[:7], packet("first")[7:]
    connected.socket.sendall(halves[0])
    reader = threading.Thread(target=connected.receive_until_closed)
    reader.start()
    wait_until(lambda: connected.transport.stat_bytes == len(halves[0]), lambda: "nothing is read")
    connected.socket.sendall(halves[1])
    wait_until(lambda: connected.words == ["first"], lambda: str(connected.words))
    connected.socket.sendall(packet("second"))
    connected.socket.shutdown(socket.SHUT_WR)
    reader.join(TIME_OUT)
    assert connected.words == ["first", "second"]


def test_a_message_longer_than_any_read_arrives(connected):
    word = "long" * 1_000_000
    sender = threading.Thread(
        target=lambda: (connected.socket.sendall(packet(word)), connected.socket.close())
    )
    sender.start()
    connected.receive_until_closed()
    sender.join(TIME_OUT)
    assert connected.words == [word]


def test_message_received_with_the_header_is_not_lost(connected):
    connected.transport.read_buff.write(packet("early")[:6])
    connected.socket.sendall(packet("early")[6:] + packet("later"))
    connected.receive_all()
    assert connected.words == ["early", "later"]


def test_a_new_connection_begins_with_a_new_message(connected):
    connected.socket.sendall(packet("whole") + packet("torn")[:6])
    connected.receive_some()
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


def test_latched_message_is_kept_for_later_callbacks(connected):
    connected.transport.is_latched = True
    connected.socket.sendall(packet("old") + packet("last"))
    connected.receive_all()
    assert connected.transport.latch.data == "last"


def test_later_subscription_receives_the_latched_message(connected, stack):
    connected.transport.is_latched = True
    connected.socket.sendall(packet("old") + packet("last"))
    connected.receive_some()
    late = Recorder(stack)
    late.subscription.receive_latched()
    connected.subscription.receive_latched()
    assert (late.words, late.may_wait) == (["last"], [False])
    assert connected.words == ["old", "last"], "the first one has heard it from the connection"


@pytest.mark.parametrize("told, expected", [([0.0], 1), ([], 0), ([incoming_topic.SUCCESSOR_S], 0)])
def test_publisher_announced_before_its_old_connection_ended_is_connected(
    connected, monkeypatch, told, expected
):
    now, looked_for = time.monotonic(), []
    monkeypatch.setattr(registration_listener, "connect", lambda *what: looked_for.append(what))
    for ago in told:
        with monkeypatch.context() as patch:
            patch.setattr(time, "monotonic", lambda: now - ago)
            assert connected.topic.has_connection("/publisher")
    connected.receive_all()
    assert (connected.transport.done, connected.topic.connections) == (True, []), "at once"
    assert looked_for == [(TOPIC, "/publisher")] * expected


def test_a_read_takes_no_more_memory_than_it_brings(connected):
    connected.socket.sendall(packet("news"))
    tracemalloc.start()
    try:
        messages = connected.transport.receive_once()
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert [message.data for message in messages] == ["news"]
    assert most < rospy.impl.tcpros_base.DEFAULT_BUFF_SIZE / 4


def test_exception_in_one_callback_does_not_stop_the_others(connected):
    def fail(messages, may_wait):
        raise ValueError("defect")

    topic = connected.impl
    incoming_topic.receive_in_batches(TOPIC, String, fail)
    late = []
    incoming_topic.receive_in_batches(
        TOPIC, String, lambda messages, may_wait: late.extend(messages)
    )
    connected.socket.sendall(packet("news"))
    connected.receive_all()
    assert connected.words == ["news"]
    assert [message.data for message in late] == ["news"]
    assert topic is get_topic_manager().get_subscriber_impl(TOPIC)


def test_limit_of_a_plain_subscriber_s_queue_holds_for_later_connections(connected, stack):
    heard = []
    plain = rospy.Subscriber(
        TOPIC, String, lambda message: heard.append(message.data), queue_size=2
    )
    connected.transport.close()
    connected.connect(stack)
    connected.socket.sendall(b"".join(map(packet, "abcde")))
    connected.receive_all()
    plain.unregister()
    assert heard == connected.words == ["d", "e"]


def test_plain_subscriber_of_the_topic_receives_the_same(connected):
    plain = []
    second = rospy.Subscriber(TOPIC, String, plain.append)
    connected.socket.sendall(packet("one") + packet("two"))
    connected.receive_all()
    second.unregister()
    assert connected.words == ["one", "two"]
    assert [message.data for message in plain] == ["one", "two"]


@pytest.mark.parametrize("known", [True, False])
def test_without_batches_messages_arrive_one_by_one(monkeypatch, known):
    with contextlib.ExitStack() as stack:
        if known:
            stack.callback(rospy.Subscriber(TOPIC, String).unregister)
        else:
            monkeypatch.setattr(incoming_topic, "subscriber_mismatch", lambda: "all is different")
        connected = Publisherless(stack)
        connected.socket.sendall(packet("one") + packet("two"))
        connected.receive_all()
        assert [len(batch) for batch in connected.batches] == [1, 1]
        assert connected.words == ["one", "two"]


def test_the_thread_of_a_connection_may_be_kept_waiting(connected):
    connected.socket.sendall(packet("news"))
    connected.receive_all()
    assert connected.may_wait == [True]


def test_batch_that_is_published_arrives_whole_and_is_counted():
    with contextlib.ExitStack() as stack:
        publisher = opened(stack, String)
        ours, theirs = (stack.enter_context(end) for end in socket.socketpair())
        transport = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
        transport.set_socket(ours, "/subscriber")
        publisher._publisher.impl.add_connection(transport)
        publisher.publish_all([])
        publisher.publish_all([String("one"), String("two")])
        expected = packet("one") + packet("two")
        assert theirs.recv(len(expected) + 1) == expected
        assert [(s.sent, s.lost) for s in publisher.statistics()] == [(2, 0)]
        transport.close()


def opened(stack, data_class, **kwds):
    """Return an open publisher that is closed with the stack."""
    publisher = Publisher(TOPIC, data_class, **kwds)
    stack.callback(publisher.close)
    publisher.open()
    return publisher


@pytest.fixture
def stack():
    with contextlib.ExitStack() as stack:
        yield stack


@pytest.fixture
def together(stack):
    """Return a publisher and a subscription of the same topic in the same process."""
    recorder = Recorder(stack)
    return opened(stack, String, latch=True), recorder


def test_subscriber_of_the_same_process_receives_without_a_connection(together, monkeypatch):
    publisher, recorder = together
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    assert recorder.impl.has_connection("http://here")
    assert not recorder.impl.has_connection("http://elsewhere")
    sent = [String("one"), String("two")]
    publisher.publish_all(sent)
    publisher.publish(String("three"))
    batches = recorder.batches
    assert [[message.data for message in batch] for batch in batches] == [["one", "two"], ["three"]]
    assert batches[0][0] is not sent[0], "each side has a message of its own"
    assert batches[0][0]._connection_header["topic"] == TOPIC


def test_link_within_the_process_counts_and_is_listed_as_a_connection(together, monkeypatch):
    publisher, recorder = together
    monkeypatch.setattr(rospy, "get_name", lambda: "/process")
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    publisher.publish_all([String("one"), String("three")])
    assert publisher.get_num_connections() == recorder.subscription.get_num_connections() == 1
    assert publisher.get_num_connections(in_process=False) == 0
    outgoing, incoming = get_topic_manager().get_pub_sub_info()
    kind = "INTRAPROCESS"
    assert outgoing[1:6] == ("/process", "o", kind, TOPIC, True)
    assert incoming[1:6] == ("http://here", "i", kind, TOPIC, True)
    [(_, _, [sent])], [(_, [received])] = get_topic_manager().get_pub_sub_stats()
    size = len(packet("one") + packet("three")) - 2 * 4
    assert sent == (outgoing[0], size, 2, True)
    assert received == (incoming[0], size, 2, -1, True)
    recorder.subscription.close()
    assert publisher.get_num_connections() == 0
    assert get_topic_manager().get_pub_sub_info() == []


def test_closed_publisher_of_the_process_is_not_a_connection(together):
    publisher, recorder = together
    assert recorder.subscription.get_num_connections() == 1
    publisher.close()
    assert recorder.subscription.get_num_connections() == 0
    assert get_topic_manager().get_pub_sub_info() == []


def test_any_type_subscriber_in_the_same_process_gets_the_type(stack, monkeypatch):
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    publisher = opened(stack, Float32, latch=True)
    recorder = Recorder(stack, rospy.AnyMsg)
    assert recorder.impl.has_connection("http://here")
    publisher.publish(Float32(0.1))
    late = Recorder(stack, rospy.AnyMsg)
    late.subscription.receive_latched()
    for (message,) in (recorder.batches[0], late.batches[0]):
        header = message._connection_header
        assert (header["type"], header["md5sum"]) == (Float32._type, Float32._md5sum)
        assert header["message_definition"] == Float32._full_text
        assert Float32().deserialize(message._buff).data == ROUNDED


def test_the_thread_that_publishes_in_the_same_process_may_not_be_kept_waiting(together, stack):
    publisher, recorder = together
    publisher.publish(String("news"))
    late = Recorder(stack)
    late.subscription.receive_latched()
    assert (recorder.may_wait, late.may_wait) == ([False], [False])


def test_numbers_are_rounded_as_for_any_other_subscriber(stack):
    recorder = Recorder(stack, Float32)
    opened(stack, Float32).publish(Float32(0.1))
    assert recorder.words == [ROUNDED]


def test_late_subscriber_of_the_same_process_gets_the_latched_message(together, stack):
    publisher, recorder = together
    publisher.publish(String("last"))
    late = Recorder(stack)
    assert late.words == [], "nothing before it is asked for"
    late.subscription.receive_latched()
    assert late.words == ["last"]
    assert len(recorder.batches) == 1


def test_the_latched_message_is_like_any_other_message_of_the_same_process(stack):
    publisher = opened(stack, Float32, latch=True)
    recorder = Recorder(stack, Float32)
    message = Float32(0.1)
    publisher.publish(message)
    late = Recorder(stack, Float32)
    late.subscription.receive_latched()
    assert late.words == recorder.words == [ROUNDED]
    (first,), (second,) = recorder.batches[0], late.batches[0]
    assert second is not message and second is not first, "each side has a message of its own"
    assert second._connection_header == first._connection_header


@pytest.mark.parametrize("latch", [True, False])
def test_without_a_latched_message_nothing_is_delivered(stack, latch):
    publisher = opened(stack, String, latch=latch)
    first = Recorder(stack)
    if not latch:
        publisher.publish(String("gone"))
    late = Recorder(stack)
    late.subscription.receive_latched()
    assert len(first.batches) == (0 if latch else 1)
    assert late.batches == []


def test_subscriber_that_publishes_in_its_callback_does_not_deadlock(together):
    publisher, recorder = together

    def answer(messages, may_wait):
        if messages[0].data != "answer":
            other = threading.Thread(target=publisher.publish, args=(String("answer"),))
            other.start()
            other.join(TIME_OUT)

    incoming_topic.receive_in_batches(TOPIC, String, answer)
    publisher.publish(String("question"))
    assert recorder.words == ["question", "answer"]


def test_closed_publisher_is_no_longer_received(together, monkeypatch):
    publisher, recorder = together
    monkeypatch.setattr(rospy, "get_node_uri", lambda: "http://here")
    publisher.close()
    assert not recorder.impl.has_connection("http://here")
    plain = rospy.Publisher(TOPIC, String, queue_size=10)
    assert not recorder.impl.has_connection("http://here"), "a plain one needs a connection"
    plain.unregister()


def test_connection_that_a_publisher_refuses_is_removed(stack, monkeypatch):
    monkeypatch.setattr(rospy.impl.tcpros_base, "_is_use_tcp_keepalive", bool)  # asks the master
    recorder, uri = Recorder(stack), "http://there"
    connection = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
    connection.set_endpoint_id(uri)
    assert recorder.impl.add_connection(connection) and recorder.impl.has_connection(uri)
    listener = stack.enter_context(socket.create_server(("localhost", 0)))

    def refuse():
        peer, _ = listener.accept()
        with peer:
            write_ros_handshake_header(peer, {"error": "not a publisher"})

    refusing = threading.Thread(target=refuse)
    refusing.start()
    stack.callback(refusing.join, TIME_OUT)
    with pytest.raises(TransportInitError, match="not a publisher"):
        connection.connect("localhost", listener.getsockname()[1], uri, timeout=TIME_OUT)
    assert not recorder.impl.has_connection(uri)


def test_second_connection_to_a_publisher_keeps_the_first(connected, monkeypatch):
    looked_for = []
    monkeypatch.setattr(registration_listener, "connect", lambda *what: looked_for.append(what))
    second = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
    second.set_endpoint_id("/publisher")
    assert not connected.topic.add_connection(second)
    connected.socket.sendall(packet("news"))
    connected.receive_all()
    assert connected.words == ["news"]
    assert looked_for == [(TOPIC, "/publisher")], "the first one may have been about to end"


def test_connection_begun_between_two_publishers_is_dropped(together, monkeypatch):
    publisher, recorder = together
    uri = "http://here"
    monkeypatch.setattr(rospy, "get_node_uri", lambda: uri)
    connection = TCPROSTransport(TCPROSSub(TOPIC, String), TOPIC)
    connection.set_endpoint_id(uri)
    assert not recorder.impl.add_connection(connection)
    publisher.close()
    assert recorder.impl.add_connection(connection)


@pytest.mark.parametrize("opened", ["subscription", "publisher"])
def test_closed_topic_leaves_no_descriptor_open(opened):
    def open_and_close():
        if opened == "publisher":
            ended = Publisher(TOPIC, String)
        else:
            ended = Subscription(TOPIC, String, lambda messages, _: None)
        ended.open()
        ended.close()

    open_and_close()
    before = os.listdir("/proc/self/fd")
    gc.disable()
    try:
        for _ in range(3):
            open_and_close()
        assert len(os.listdir("/proc/self/fd")) == len(before)
    finally:
        gc.enable()


def test_closed_subscription_receives_nothing_from_a_connection_while_others_do(connected, stack):
    other = Recorder(stack)
    topic = connected.impl
    assert other.impl is topic
    connected.subscription.close()
    connected.socket.sendall(packet("news"))
    topic.receive_callback(connected.transport.receive_once(), connected.transport)
    assert (connected.batches, other.words) == ([], ["news"])
    assert get_topic_manager().get_subscriber_impl(TOPIC) is topic
    other.subscription.close()
    assert get_topic_manager().get_subscriber_impl(TOPIC) is None
    topic.receive_callback([String("late")], connected.transport)
    assert (connected.batches, other.words) == ([], ["news"])
    assert connected.subscription.get_num_connections() == 0


def test_closed_subscription_receives_nothing_from_its_process_while_others_do(together, stack):
    publisher, recorder = together
    other = Recorder(stack)
    publisher.publish(String("before"))
    for _ in range(2):
        recorder.subscription.close()
    publisher.publish(String("after"))
    assert recorder.words == ["before"]
    assert other.words == ["before", "after"]


def test_two_subscriptions_with_one_callback_are_closed_one_by_one(stack):
    publisher = opened(stack, String)
    first, heard = Recorder(stack), []
    second = Subscription(TOPIC, String, first.receive)
    stack.callback(second.close)
    second.open()
    publisher.publish(String("both"))
    heard += first.words
    second.close()
    publisher.publish(String("one"))
    assert (heard, first.words) == (["both", "both"], ["both", "both", "one"])


def test_subscription_that_opens_while_the_last_other_closes_receives(stack, monkeypatch):
    publisher = opened(stack, String)
    closing = threading.Thread(target=Recorder(stack).subscription.close)
    subscribe = rospy.Subscriber

    def close_other_and_subscribe(*args, **kwds):
        closing.start()
        closing.join(0.2)  # or it waits until ours is open
        return subscribe(*args, **kwds)

    monkeypatch.setattr(rospy, "Subscriber", close_other_and_subscribe)
    ours = Recorder(stack)
    closing.join(TIME_OUT)
    publisher.publish(String("news"))
    assert ours.words == ["news"]


def test_plain_subscriber_keeps_receiving_after_ours_is_closed(connected):
    plain = []
    second = rospy.Subscriber(TOPIC, String, plain.append)
    connected.subscription.close()
    connected.socket.sendall(packet("news"))
    second.impl.receive_callback(connected.transport.receive_once(), connected.transport)
    second.unregister()
    assert (connected.words, [message.data for message in plain]) == ([], ["news"])


@pytest.mark.parametrize("known", [True, False])
def test_without_batches_closing_ends_it_too(monkeypatch, known):
    with contextlib.ExitStack() as stack:
        plain = []
        if not known:
            monkeypatch.setattr(incoming_topic, "subscriber_mismatch", lambda: "all is different")
        second = rospy.Subscriber(TOPIC, String, plain.append)
        stack.callback(second.unregister)
        connected = Publisherless(stack)
        topic = connected.impl
        connected.subscription.close()
        connected.socket.sendall(packet("news"))
        topic.receive_callback(connected.transport.receive_once(), connected.transport)
        assert (connected.words, [message.data for message in plain]) == ([], ["news"])


def test_latest_keeps_the_newest_message_and_knows_how_old_it_is(stack):
    publisher = opened(stack, String)
    latest = LatestMessage(TOPIC, String)
    assert (latest.message, latest.age) == (None, float("inf"))
    stack.callback(latest.subscription.close)
    latest.subscription.open()
    before = time.monotonic()
    publisher.publish_all([String("old"), String("new")])
    assert latest.message.data == "new"
    assert 0.0 <= latest.age <= time.monotonic() - before


def test_recorder_of_a_test_receives_messages_during_registration(monkeypatch):
    manager = get_topic_manager()
    add = manager._add

    def add_and_receive(ps, rmap, reg_type):
        add(ps, rmap, reg_type)
        ps.receive_callback([String("latched")], None)

    monkeypatch.setattr(manager, "_add", add_and_receive)
    heard, heard_too = [], []
    first = latched.subscribe_without_loss(TOPIC, String, heard.append)
    second = latched.subscribe_without_loss(TOPIC, String, heard_too.append)
    impl = first.impl
    impl.receive_callback([String("next")], None)
    first.unregister()
    impl.receive_callback([String("last")], None)
    second.unregister()
    assert [message.data for message in heard] == ["latched", "next"]
    assert [message.data for message in heard_too] == ["next", "last"]
    assert manager.get_subscriber_impl(TOPIC) is None


def test_second_type_of_a_topic_is_refused_and_receives_nothing(connected):
    heard = []
    other = Subscription(TOPIC, Float32, lambda messages, may_wait: heard.extend(messages))
    with pytest.raises(rospy.ROSException, match="refused std_msgs/Float32: must be std_msgs/Str"):
        other.open()
    other.close()
    connected.socket.sendall(packet("news"))
    connected.receive_all()
    assert (connected.words, heard) == (["news"], [])
