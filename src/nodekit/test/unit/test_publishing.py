"""The publisher inside rospy's own objects, with sockets in place of subscribers and no master."""

import contextlib
import socket
import struct
import threading
import warnings

import pytest
import rospy
import rospy.topics
from rosgraph_msgs.msg import Log
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import QueuedConnection, TCPROSPub
from std_msgs.msg import Header, String

from nodekit.messaging.publisher import FALLBACK_QUEUE_SIZE, Publisher
from nodekit.rospy_internals import publishers, shutdown

TOPIC = "/topic"
TIME_OUT = 20.0  # s


@pytest.fixture
def publish_on():
    """Give a maker of publishers that are unregistered afterwards."""
    with contextlib.ExitStack() as stack:

        def make(maker, *args, **kwds):
            publisher = maker(TOPIC, *args, **kwds)
            stack.callback(publisher.unregister)
            return publisher

        yield make


@pytest.fixture
def connect():
    """Give a maker of subscribers: connects one to a publisher and gives its end."""
    with contextlib.ExitStack() as stack:

        def make(publisher, name="/subscriber"):
            ours, theirs = (stack.enter_context(end) for end in socket.socketpair())
            transport = TCPROSTransport(TCPROSPub(TOPIC, publisher.data_class), TOPIC)
            transport.set_socket(ours, name)
            stack.callback(transport.close)
            publisher.impl.add_connection(transport)
            theirs.settimeout(TIME_OUT)
            return theirs

        yield make


@pytest.fixture
def mismatch():
    """Forget what was found out about rospy, before and after."""
    publishers.publisher_mismatch.cache_clear()
    yield publishers.publisher_mismatch
    publishers.publisher_mismatch.cache_clear()


def receive(sock, data_class=String):
    (size,) = struct.unpack("<I", receive_bytes(sock, 4))
    return data_class().deserialize(receive_bytes(sock, size))


def receive_bytes(sock, size):
    data = b""
    while len(data) < size:
        data += sock.recv(size - len(data))
    return data


def test_this_rospy_is_known(mismatch):
    assert mismatch() == ""


def test_old_rospy_can_shut_down_on_new_python(monkeypatch):
    ended = threading.Thread()
    monkeypatch.setattr(rospy.core, "signal_shutdown", lambda reason: ended.isAlive())
    monkeypatch.setattr(threading.Thread, "isAlive", None, raising=False)
    shutdown.mend_shutdown()
    assert rospy.core.signal_shutdown("test") is False


@pytest.mark.parametrize("part", ["_PUBLISHER_ATTRIBUTES", "_TRANSPORT_ATTRIBUTES"])
def test_missing_attribute_is_recognised(mismatch, monkeypatch, part):
    monkeypatch.setattr(publishers, part, "close something_else")
    assert "something_else" in mismatch()


def test_other_parameters_of_publish_are_recognised(mismatch, monkeypatch):
    monkeypatch.setattr(rospy.topics._PublisherImpl, "publish", lambda self, message: None)
    assert mismatch() != ""


def test_absent_internals_are_recognised(mismatch, monkeypatch):
    monkeypatch.delattr(rospy.topics, "_PublisherImpl")
    assert mismatch() != ""


def test_unknown_rospy_means_a_plain_publisher(publish_on, connect, monkeypatch):
    monkeypatch.setattr(publishers, "publisher_mismatch", lambda: "all is different")
    publisher = publish_on(Publisher, String, latch=True)
    assert publisher.impl.queue_size == FALLBACK_QUEUE_SIZE
    assert publisher.impl.is_latch
    subscriber = connect(publisher)
    publisher.impl.publish(String("plain"))
    assert receive(subscriber).data == "plain"
    assert publisher.statistics() == []


def test_construction_warns_of_nothing(publish_on):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        publish_on(Publisher, String)


def test_messages_are_counted_where_rosnode_and_diagnostics_look(publish_on, connect, monkeypatch):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = publish_on(Publisher, String)
    subscribers = [connect(publisher, name) for name in ("/one", "/two")]
    publisher.publish(String("first"))
    publisher.publish("second")
    publisher.publish(data="third")
    for subscriber in subscribers:
        assert [receive(subscriber).data for _ in range(3)] == ["first", "second", "third"]
    assert [(s.node, s.sent, s.lost, s.stalled) for s in publisher.statistics()] == [
        ("/one", 3, 0, False),
        ("/two", 3, 0, False),
    ]
    size = 3 * 8 + len("firstsecondthird")
    name, total, connections = publisher.impl.get_stats()
    assert (name, total) == (TOPIC, size)
    assert [connection[1:] for connection in connections] == [(size, 3, True)] * 2


def test_small_messages_are_not_held_back(publish_on):
    publisher = publish_on(Publisher, String)
    with socket.create_server(("localhost", 0)) as server:
        with socket.create_connection(server.getsockname()) as ours, server.accept()[0] as theirs:
            transport = TCPROSTransport(TCPROSPub(TOPIC, String), TOPIC)
            transport.set_socket(ours, "/subscriber")
            publisher.impl.add_connection(transport)
            publisher.publish(String("news"))
            assert receive(theirs).data == "news"
            assert ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
            transport.close()


def test_header_gets_its_sequence_number(publish_on, connect):
    publisher = publish_on(Publisher, Log)
    subscriber = connect(publisher)
    for _ in range(2):
        publisher.publish(Log())
    assert [receive(subscriber, Log).header.seq for _ in range(2)] == [1, 2]


def test_late_joiner_of_latched_topic_gets_the_last_message_alone(publish_on, connect):
    publisher = publish_on(Publisher, String, latch=True)
    early = connect(publisher, "/early")
    for word in ("old", "last"):
        publisher.publish(String(word))
    late = connect(publisher, "/late")
    publisher.publish(String("new"))
    assert [receive(early).data for _ in range(3)] == ["old", "last", "new"]
    assert [receive(late).data for _ in range(2)] == ["last", "new"]


def test_latched_late_joiner_that_does_not_read_delays_nobody_else(publish_on, connect):
    publisher = publish_on(Publisher, String, latch=True)
    good = connect(publisher, "/good")
    long = "l" * 1_000_000
    reader = threading.Thread(target=receive, args=(good,))
    reader.start()
    publisher.publish(String(long))
    reader.join(TIME_OUT)
    stalled = connect(publisher, "/stalled")
    publisher.publish(String("news"))
    assert receive(good).data == "news"
    assert [s.stalled for s in publisher.statistics()] == [False, True]
    assert [receive(stalled).data for _ in range(2)] == [long, "news"]


def test_publishers_of_one_topic_share_its_connections(publish_on, connect):
    ours = [publish_on(Publisher, String) for _ in range(2)]
    plain = publish_on(rospy.Publisher, String, queue_size=10)
    subscriber = connect(plain)
    assert [type(connection) for connection in plain.impl.connections] == [TCPROSTransport]
    words = [str(number) for number in range(6)]
    for word, publisher in zip(words, 3 * ours):
        publisher.publish(String(word))
    plain.impl.publish(String("plain"))
    assert [receive(subscriber).data for _ in range(7)] == words + ["plain"]
    for publisher in ours:
        assert [(s.node, s.sent) for s in publisher.statistics()] == [("/subscriber", 7)]


def test_where_there_is_a_plain_publisher_its_queue_is_used(publish_on, connect):
    plain = publish_on(rospy.Publisher, String, queue_size=10)
    subscriber = connect(plain)
    ours = publish_on(Publisher, String)
    assert ours.impl is plain.impl
    assert isinstance(ours.impl.connections[0], QueuedConnection)
    ours.impl.publish(String("news"))
    assert receive(subscriber).data == "news"
    assert ours.statistics() == []


def test_subscriber_that_has_gone_is_forgotten(publish_on, connect):
    publisher = publish_on(Publisher, String)
    gone, rest = (connect(publisher, name) for name in ("/gone", "/rest"))
    gone.close()
    publisher.publish(String("news"))
    assert [subscriber.node for subscriber in publisher.statistics()] == ["/rest"]
    assert publisher.get_num_connections() == 1
    assert receive(rest).data == "news"


def test_threads_do_not_cut_into_each_others_messages(publish_on, connect):
    publisher = publish_on(Publisher, String)
    subscriber = connect(publisher)
    words = {letter: letter * 50_000 for letter in "ab"}

    def publish(letter):
        for _ in range(50):
            publisher.publish(String(words[letter]))

    threads = [threading.Thread(target=publish, args=(letter,)) for letter in words]
    for thread in threads:
        thread.start()
    received = [receive(subscriber).data for _ in range(100)]
    for thread in threads:
        thread.join(TIME_OUT)
    assert sorted(received) == sorted(50 * list(words.values()))


def test_value_that_does_not_fit_is_refused_and_sends_nothing(publish_on, connect):
    publisher = publish_on(Publisher, Header)
    subscriber = connect(publisher)
    with pytest.raises(rospy.ROSSerializationException):
        publisher.publish(Header(frame_id=3.14))
    publisher.publish(Header(frame_id="good"))
    assert receive(subscriber, Header).frame_id == "good"


def test_publishing_without_a_node_is_refused(publish_on):
    publisher = publish_on(Publisher, String)
    with pytest.raises(rospy.ROSException):
        publisher.publish(String())


def test_closed_topic_is_an_error_except_during_shutdown(publish_on, monkeypatch):
    publisher = publish_on(Publisher, String)
    publisher.impl.close()
    with pytest.raises(rospy.ROSException):
        publisher.publish(String())
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    publisher.publish(String())
    assert publisher.statistics() == []


def test_unregistered_publisher_refuses(publish_on):
    publisher = publish_on(Publisher, String)
    publisher.unregister()
    with pytest.raises(rospy.ROSException):
        publisher.publish(String())
