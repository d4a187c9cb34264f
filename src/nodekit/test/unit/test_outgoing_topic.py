"""Tests of the published topic, with sockets in place of subscribers and without a master."""

import contextlib
import fcntl
import re
import socket
import struct
import threading
import types
import warnings

import pytest
import rospy
import rospy.topics
from rosgraph_msgs.msg import Log
from rospy.impl.registration import get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import QueuedConnection, TCPROSPub
from std_msgs.msg import Float32, Header, String

from nodekit.messaging.publisher import FALLBACK_QUEUE_SIZE, Publisher
from nodekit.process_context import PROCESS
from nodekit.rospy_internals import outgoing_topic, shutdown
from nodekit.testing.waiting import wait_until
from nodekit.transport import delivery, subscriber_connection

TOPIC = "/topic"
TIME_OUT = 20.0  # s
#: The size of a picture of 1920 x 1080 pixels in colour.
LARGE = 6_220_800 * "x"


@pytest.fixture
def unopened():
    """Give a maker of publishers that are closed afterwards."""
    with contextlib.ExitStack() as stack:

        def make(data_class, **kwds):
            publisher = Publisher(TOPIC, data_class, **kwds)
            stack.callback(publisher.close)
            return publisher

        yield make


@pytest.fixture
def opened(unopened):
    """Give a maker of publishers that are open."""

    def make(data_class, **kwds):
        publisher = unopened(data_class, **kwds)
        publisher.open()
        return publisher

    return make


@pytest.fixture
def make_plain():
    """Give a maker of rospy's own publishers, which are unregistered afterwards."""
    with contextlib.ExitStack() as stack:

        def make():
            publisher = rospy.Publisher(TOPIC, String, queue_size=10)
            stack.callback(publisher.unregister)
            return publisher

        yield make


@pytest.fixture
def connect():
    """Give a maker of subscribers: connects one to a publisher and gives its end."""
    with contextlib.ExitStack() as stack:

        def make(publisher, name="/subscriber", ends=None):
            ours, theirs = (stack.enter_context(end) for end in ends or socket.socketpair())
            transport = TCPROSTransport(TCPROSPub(TOPIC, publisher.data_class), TOPIC)
            transport.set_socket(ours, name)
            stack.callback(transport.close)
            impl(publisher).add_connection(transport)
            theirs.settimeout(TIME_OUT)
            return theirs

        yield make


@pytest.fixture
def mismatch():
    """Clear the cached check of rospy, before and after."""
    outgoing_topic.publisher_mismatch.cache_clear()
    yield outgoing_topic.publisher_mismatch
    outgoing_topic.publisher_mismatch.cache_clear()


def impl(publisher):
    """Return rospy's object behind a publisher, ours or its own."""
    return getattr(publisher, "_publisher", publisher).impl


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


@pytest.mark.parametrize("part", ["_PUBLISHER_ATTRIBUTES", "_TRANSPORT_ATTRIBUTES"])
def test_missing_attribute_is_recognised(mismatch, monkeypatch, part):
    monkeypatch.setattr(outgoing_topic, part, "close something_else")
    assert "something_else" in mismatch()


def test_other_parameters_of_publish_are_recognised(mismatch, monkeypatch):
    monkeypatch.setattr(rospy.topics._PublisherImpl, "publish", lambda self, message: None)
    assert mismatch() != ""


def test_absent_internals_are_recognised(mismatch, monkeypatch):
    monkeypatch.delattr(rospy.topics, "_PublisherImpl")
    assert mismatch() != ""


def test_unknown_rospy_means_a_plain_publisher(opened, connect, monkeypatch):
    monkeypatch.setattr(outgoing_topic, "publisher_mismatch", lambda: "all is different")
    publisher = opened(String, latch=True)
    assert impl(publisher).queue_size == FALLBACK_QUEUE_SIZE
    assert impl(publisher).is_latch
    subscriber = connect(publisher)
    impl(publisher).publish(String("plain"))
    assert receive(subscriber).data == "plain"
    assert publisher.statistics() == []


@pytest.mark.parametrize(
    "queue_size, pause",
    [
        (10, 10),
        pytest.param(40, 32, marks=pytest.mark.extended),
        pytest.param(0, 35, marks=pytest.mark.extended),
        pytest.param(-1, 35, marks=pytest.mark.extended),
    ],
)
def test_large_messages_within_the_queue_size_survive_a_pause(opened, connect, queue_size, pause):
    publisher = opened(String, queue_size=queue_size)
    subscriber = connect(publisher)
    texts = [str(number) + LARGE for number in range(1 + pause)]  # one is partly sent
    for text in texts:
        publisher.publish(String(text))
    assert [receive(subscriber).data == text for text in texts] == [True] * len(texts)
    assert [(one.lost, one.stalled) for one in publisher.statistics()] == [(0, False)]


def test_queue_size_one_keeps_the_newest_and_counts_the_others(opened, connect):
    publisher = opened(String, queue_size=1)
    subscriber = connect(publisher)
    for number in range(10):
        publisher.publish(String(str(number) + LARGE))
    assert [receive(subscriber).data.rstrip("x") for _ in range(2)] == ["0", "9"]
    wait_until(lambda: publisher.statistics()[0].sent == 2, lambda: "not sent")
    assert publisher.statistics()[0].lost == 8


def test_largest_queue_size_of_a_topic_counts_for_connected_subscribers_too(opened, connect):
    subscriber = connect(opened(String, queue_size=1))
    publisher = opened(String, queue_size=5)
    opened(String, queue_size=2)
    for number in range(8):
        publisher.publish(String(str(number) + LARGE))
    heard = [receive(subscriber).data.rstrip("x") for _ in range(6)]
    assert heard == ["0", "3", "4", "5", "6", "7"]


@pytest.mark.parametrize("queue_size", [-2, 1.5, "10"])
def test_invalid_queue_size_is_refused(unopened, queue_size):
    must = "must be a whole number of at least 1, or 0 or -1 for no limit"
    with pytest.raises(ValueError, match=f"{TOPIC}: queue_size: refused {queue_size!r}: {must}"):
        unopened(String, queue_size=queue_size)


def test_unknown_rospy_gets_the_queue_size(opened, monkeypatch):
    monkeypatch.setattr(outgoing_topic, "publisher_mismatch", lambda: "all is different")
    assert impl(opened(String, queue_size=3)).queue_size == 3


def test_construction_warns_of_nothing(opened):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        opened(String)


def test_messages_are_counted_where_rosnode_and_diagnostics_look(opened, connect, monkeypatch):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = opened(String)
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
    name, total, connections = impl(publisher).get_stats()
    assert (name, total) == (TOPIC, size)
    assert [connection[1:] for connection in connections] == [(size, 3, True)] * 2


def test_later_subscriber_gets_the_last_message_while_it_is_alive(opened, connect, monkeypatch):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    now = [100.0]
    monkeypatch.setattr(outgoing_topic, "time", types.SimpleNamespace(monotonic=lambda: now[0]))
    publisher = opened(String, lifespan=0.1)
    monkeypatch.setattr(rospy.core, "is_initialized", lambda: True)
    publisher.publish(String("early"))
    now[0] += 0.09
    in_time = connect(publisher)
    now[0] += 0.02
    late = connect(publisher, "/late")
    publisher.publish(String("next"))
    assert [receive(in_time).data for _ in range(2)] == ["early", "next"]
    assert receive(late).data == "next"


def test_longest_lifespan_of_a_topic_counts(opened, connect, monkeypatch):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    monkeypatch.setattr(rospy.core, "is_initialized", lambda: True)
    for lifespan in (0.0, 60.0, 0.0):
        publisher = opened(String, lifespan=lifespan)
    publisher.publish(String("early"))
    assert receive(connect(publisher)).data == "early"


@pytest.mark.parametrize("kept", [{"lifespan": 60.0}, {"latch": True}])
def test_subscriber_that_was_sent_a_message_is_not_sent_it_again(
    opened, connect, monkeypatch, kept
):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = opened(String, **kept)
    add_connection = rospy.topics._TopicImpl.add_connection

    def add_and_publish(topic, connection):
        add_connection(topic, connection)
        publisher.publish(String("once"))

    monkeypatch.setattr(rospy.topics._TopicImpl, "add_connection", add_and_publish)
    subscriber = connect(publisher)
    publisher.publish(String("next"))
    assert [receive(subscriber).data for _ in range(2)] == ["once", "next"]


@pytest.mark.parametrize("kept", [{"lifespan": 60.0}, {"latch": True}])
def test_subscriber_that_is_only_counted_while_it_connects_is_sent_the_last_message(
    opened, connect, monkeypatch, kept
):
    monkeypatch.setattr(rospy.core, "is_initialized", lambda: True)
    publisher = opened(String, **kept)
    publisher.publish(String("early"))
    add_connection = rospy.topics._TopicImpl.add_connection

    def add_and_count(topic, connection):
        add_connection(topic, connection)
        assert len(publisher.statistics()) == 1

    monkeypatch.setattr(rospy.topics._TopicImpl, "add_connection", add_and_count)
    assert receive(connect(publisher)).data == "early"


def test_small_messages_are_not_held_back(opened):
    publisher = opened(String)
    with socket.create_server(("localhost", 0)) as server:
        with socket.create_connection(server.getsockname()) as ours, server.accept()[0] as theirs:
            transport = TCPROSTransport(TCPROSPub(TOPIC, String), TOPIC)
            transport.set_socket(ours, "/subscriber")
            impl(publisher).add_connection(transport)
            publisher.publish(String("news"))
            assert receive(theirs).data == "news"
            assert ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
            transport.close()


def test_header_gets_its_sequence_number(opened, connect):
    publisher = opened(Log)
    subscriber = connect(publisher)
    for _ in range(2):
        publisher.publish(Log())
    assert [receive(subscriber, Log).header.seq for _ in range(2)] == [1, 2]


def test_late_joiner_of_latched_topic_gets_the_last_message_alone(opened, connect):
    publisher = opened(String, latch=True)
    early = connect(publisher, "/early")
    for word in ("old", "last"):
        publisher.publish(String(word))
    late = connect(publisher, "/late")
    publisher.publish(String("new"))
    assert [receive(early).data for _ in range(3)] == ["old", "last", "new"]
    assert [receive(late).data for _ in range(2)] == ["last", "new"]


def test_latched_late_joiner_that_does_not_read_delays_no_other(opened, connect):
    publisher = opened(String, latch=True)
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


def test_publishers_of_one_topic_share_its_connections(opened, make_plain, connect):
    ours = [opened(String) for _ in range(2)]
    plain = make_plain()
    subscriber = connect(plain)
    assert [type(connection) for connection in impl(plain).connections] == [TCPROSTransport]
    words = [str(number) for number in range(6)]
    for word, publisher in zip(words, 3 * ours):
        publisher.publish(String(word))
    impl(plain).publish(String("plain"))
    assert [receive(subscriber).data for _ in range(7)] == words + ["plain"]
    for publisher in ours:
        assert [(s.node, s.sent) for s in publisher.statistics()] == [("/subscriber", 7)]


def test_where_there_is_a_plain_publisher_its_queue_is_used(opened, make_plain, connect):
    plain = make_plain()
    subscriber = connect(plain)
    ours = opened(String)
    assert impl(ours) is impl(plain)
    assert isinstance(impl(ours).connections[0], QueuedConnection)
    impl(ours).publish(String("news"))
    assert receive(subscriber).data == "news"
    assert ours.statistics() == []


def test_closed_topic_gives_back_its_shared_memory(opened):
    publisher = opened(String)
    memory = publisher._topic._memory
    assert memory.write([b"content"], 0, 0, 0) is not None
    assert memory.pool.size
    publisher.close()
    assert not memory.pool.size


def test_subscriber_that_has_gone_is_forgotten(opened, connect):
    publisher = opened(String)
    gone, rest = (connect(publisher, name) for name in ("/gone", "/rest"))
    gone.close()
    publisher.publish(String("news"))
    assert [subscriber.node for subscriber in publisher.statistics()] == ["/rest"]
    assert publisher.get_num_connections() == 1
    assert receive(rest).data == "news"


def test_subscriber_that_disconnects_while_the_topic_closes_raises_nothing(
    opened, connect, monkeypatch
):
    publisher = opened(String)
    connect(publisher).close()
    topic = impl(publisher)
    lists = topic.connections, topic.subscriber_listeners

    def closing(_connections, _one):
        topic.closed, topic.subscriber_listeners = True, None

    monkeypatch.setattr(topic, "_remove_connection", closing)
    topic.remove_connection(lists[0][0])
    topic.closed = False
    with pytest.raises(TypeError):  # an error that the shutdown does not cause
        monkeypatch.setattr(topic, "_remove_connection", lambda *_: None)
        topic.remove_connection(lists[0][0])
    topic.connections, topic.subscriber_listeners = lists


class Gone(socket.socket):
    """Socket of a subscriber that has gone; calls a function when it is closed."""

    def close(self):
        if self.fileno() >= 0:
            super().close()
            self.then()


@pytest.mark.parametrize("name", ["/subscriber", "/another"])
def test_new_subscriber_with_a_reused_descriptor_is_kept(opened, connect, name):
    publisher = opened(String, latch=True)
    theirs = connect(publisher)
    (transport,) = impl(publisher).connections
    transport.socket = gone = Gone(fileno=transport.socket.detach())
    descriptor, threads = gone.fileno(), []
    ours, end = socket.socketpair()

    def come():
        with ours:  # as if this descriptor were the lowest that is free
            number = fcntl.fcntl(ours.fileno(), fcntl.F_DUPFD, descriptor)
        # Waits at the end for the one who publishes.
        connect(publisher, name, (socket.socket(fileno=number), end))

    def has_come():
        return any(each is not transport for each in impl(publisher).connections)

    def then():
        threads.append(threading.Thread(target=come))
        threads[0].start()
        wait_until(has_come, lambda: "the new one does not come")

    gone.then = then
    theirs.close()
    publisher.publish(String("second"))  # finds that it has gone
    threads[0].join(TIME_OUT)
    (new,) = impl(publisher).connections
    assert new.fileno() == descriptor
    assert receive(end).data == "second"
    publisher.publish(String("third"))
    assert receive(end).data == "third"


def test_no_connection_is_added_while_ended_ones_are_removed(opened, monkeypatch):
    topic = impl(opened(String))
    free = []

    def come():
        free.append(topic.c_lock.acquire(blocking=False))
        if free[0]:
            topic.c_lock.release()

    def look():
        other = threading.Thread(target=come)
        other.start()
        other.join(TIME_OUT)
        return iter(())

    monkeypatch.setattr(topic.connection_poll, "error_iter", look)
    topic.check()
    assert free == [False]


def test_threads_do_not_cut_into_each_others_messages(opened, connect):
    publisher = opened(String)
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


def test_value_that_does_not_fit_is_refused_and_sends_nothing(opened, connect):
    publisher = opened(Header)
    subscriber = connect(publisher)
    with pytest.raises(rospy.ROSSerializationException):
        publisher.publish(Header(frame_id=3.14))
    publisher.publish(Header(frame_id="good"))
    assert receive(subscriber, Header).frame_id == "good"


@pytest.mark.parametrize("latch", [True, False])
@pytest.mark.parametrize("is_open", [True, False])
@pytest.mark.parametrize(
    "args, kwds, problem",
    [
        ((3,), {}, f"topic {TOPIC}: refused (3,): field data must be of type"),
        ((), {"data": 3}, f"topic {TOPIC}: refused {{'data': 3}}: field data must be of type"),
        ((String,), {}, "refused the class String: must be a message, such as String()"),
        ((Float32,), {}, "refused the class Float32: must be a message, such as String()"),
        ((Float32(3.0),), {}, ""),
        (("a", "b"), {}, ""),
        (("a",), {"data": "b"}, ""),
    ],
)
def test_wrong_arguments_without_subscriber_are_a_type_error(
    opened, unopened, monkeypatch, latch, is_open, args, kwds, problem
):
    monkeypatch.setattr(rospy.core, "is_initialized", lambda: True)
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = (opened if is_open else unopened)(String, latch=latch)
    with pytest.raises(TypeError, match=re.escape(problem)):
        publisher.publish(*args, **kwds)


def test_wrong_field_is_still_a_serialization_error(opened, connect, monkeypatch):
    monkeypatch.setattr(rospy.topics, "is_initialized", lambda: True)
    publisher = opened(String)
    subscriber = connect(publisher)
    with pytest.raises(rospy.ROSSerializationException):
        publisher.publish(3)
    publisher.publish("good")
    assert receive(subscriber).data == "good"


@pytest.mark.parametrize("latch, lifespan", [(True, 0.0), (False, 60.0)])
def test_later_subscriber_gets_the_last_message_that_fitted(
    opened, connect, monkeypatch, latch, lifespan
):
    for module in (rospy.core, rospy.topics):
        monkeypatch.setattr(module, "is_initialized", lambda: True)
    publisher = opened(String, latch=latch, lifespan=lifespan)
    publisher.publish(String("good"))
    with pytest.raises(rospy.ROSSerializationException):
        publisher.publish(String(5))
    assert receive(connect(publisher)).data == "good"


def test_publishing_without_a_node_is_refused(opened):
    publisher = opened(String)
    with pytest.raises(rospy.ROSException):
        publisher.publish(String())


def test_closed_topic_is_an_error_except_during_shutdown(opened, monkeypatch):
    publisher = opened(String)
    impl(publisher).close()
    with pytest.raises(rospy.ROSException):
        publisher.publish(String())
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    publisher.publish(String())
    assert publisher.statistics() == []


@pytest.mark.parametrize("is_open", [True, False])
def test_closed_publisher_refuses(unopened, is_open):
    publisher = unopened(String, latch=True)
    if is_open:
        publisher.open()
    for _ in range(2):
        publisher.close()
    for publish, argument in (
        (publisher.publish, String()),
        (publisher.publish, "text"),
        (publisher.publish_all, [String()]),
    ):
        with pytest.raises(rospy.ROSException, match="closed publisher of " + TOPIC):
            publish(argument)
    assert (publisher.statistics(), publisher.get_num_connections()) == ([], 0)


def test_closing_one_publisher_leaves_the_others_of_its_topic_alone(opened, connect):
    closed, other = (opened(String) for _ in range(2))
    subscriber = connect(closed)
    closed.close()
    other.publish(String("news"))
    assert receive(subscriber).data == "news"
    assert get_topic_manager().get_publisher_impl(TOPIC) is impl(other)
    other.close()
    assert get_topic_manager().get_publisher_impl(TOPIC) is None
    assert subscriber.recv(1) == b"", "the last one ends the connections"


@pytest.mark.parametrize("known", [True, False])
def test_message_latched_before_opening_is_sent_on_opening(unopened, connect, monkeypatch, known):
    for module in (rospy.core, rospy.topics):
        monkeypatch.setattr(module, "is_initialized", lambda: True)
    if not known:
        monkeypatch.setattr(outgoing_topic, "publisher_mismatch", lambda: "all is different")
    publisher = unopened(String, latch=True)
    publisher.publish(String("old"))
    publisher.publish_all([String("older"), String("newer")])
    publisher.publish(data="last")
    assert publisher.get_num_connections() == 0
    publisher.open()
    subscriber = connect(publisher)
    publisher.publish("new")
    assert [receive(subscriber).data for _ in range(2)] == ["last", "new"]


def after(function, do):
    """Return a function that has something done, once, before it returns."""
    to_do = [do]

    def wrapped(*args, **kwds):
        result = function(*args, **kwds)
        if to_do:
            to_do.pop()()
        return result

    return wrapped


def test_message_latched_while_opening_replaces_the_one_before(unopened, connect, monkeypatch):
    for module in (rospy.core, rospy.topics):
        monkeypatch.setattr(module, "is_initialized", lambda: True)
    publisher = unopened(String, latch=True)
    publisher.publish(String("before"))
    publish = after(rospy.Publisher, lambda: publisher.publish(String("meanwhile")))
    monkeypatch.setattr(rospy, "Publisher", publish)
    publisher.open()
    assert receive(connect(publisher)).data == "meanwhile"


def test_message_latched_while_the_publisher_opens_is_sent(unopened, connect, monkeypatch):
    for module in (rospy.core, rospy.topics):
        monkeypatch.setattr(module, "is_initialized", lambda: True)
    publisher = unopened(String, latch=True)
    monkeypatch.setattr(
        rospy.msg, "args_kwds_to_message", after(rospy.msg.args_kwds_to_message, publisher.open)
    )
    publisher.publish(data="now")
    assert receive(connect(publisher)).data == "now"


def test_unlatched_message_before_opening_is_not_sent(unopened, connect):
    publisher = unopened(String)
    publisher.publish(String("early"))
    publisher.open()
    subscriber = connect(publisher)
    publisher.publish(String("news"))
    assert receive(subscriber).data == "news"


def test_opening_publishes_nothing_of_itself(unopened, connect):
    publisher = unopened(String, latch=True)
    publisher.open()
    subscriber = connect(publisher)
    publisher.publish(String("news"))
    assert receive(subscriber).data == "news"
    assert [s.sent for s in publisher.statistics()] == [1]


@pytest.mark.parametrize("closes", [True, False])
def test_messages_held_at_the_end_of_the_process_are_sent(opened, connect, monkeypatch, closes):
    monkeypatch.setattr(delivery, "CLOSING_PATIENCE_S", TIME_OUT)  # a busy machine is slow
    monkeypatch.setattr(subscriber_connection, "CLOSING_STALL_S", TIME_OUT)
    publisher = opened(String, queue_size=20)
    subscriber = connect(publisher)
    for number in range(20):
        publisher.publish(String(chr(97 + number) * 1_000_000))
    received = []
    reader = threading.Thread(
        target=lambda: received.extend(receive(subscriber).data[0] for _ in range(20))
    )
    plain = publisher._publisher
    if closes:  # as a managed node does, which has 2 s for all of its shutdown
        with monkeypatch.context() as patch:
            patch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
            publisher.close()
    reader.start()
    for send_held in PROCESS.get(shutdown._Hooks)[shutdown.ShutdownPhase.PUBLISHERS]:
        send_held()
    plain.unregister()
    reader.join(TIME_OUT)
    assert "".join(received) == "abcdefghijklmnopqrst"


def test_publisher_that_opens_while_the_last_other_closes_is_received(
    opened, unopened, connect, monkeypatch
):
    other, ours = opened(String), unopened(String)
    closing = threading.Thread(target=other.close)
    advertise = rospy.Publisher

    def close_other_and_advertise(*args, **kwds):
        closing.start()
        closing.join(0.2)  # or it waits until ours is open
        return advertise(*args, **kwds)

    monkeypatch.setattr(rospy, "Publisher", close_other_and_advertise)
    ours.open()
    closing.join(TIME_OUT)
    subscriber = connect(ours)
    ours.publish(String("news"))
    assert receive(subscriber).data == "news"
    assert [s.sent for s in ours.statistics()] == [1]


def test_second_type_of_a_topic_is_refused_without_side_effects(opened, unopened, connect):
    first, other = opened(String), unopened(Float32)
    subscriber = connect(first)
    text = f"topic {TOPIC}: refused std_msgs/Float32: must be std_msgs/String, as elsewhere"
    with pytest.raises(rospy.ROSException, match=text):
        other.open()
    other.close()
    first.publish(String("news"))
    assert receive(subscriber).data == "news"


def test_the_last_of_several_stays_latched_and_an_empty_batch_keeps_it(opened, connect):
    publisher = opened(String, latch=True)
    connect(publisher)
    publisher.publish_all([String("older"), String("newer")])
    publisher.publish_all([])
    assert receive(connect(publisher)).data == "newer"


def test_later_subscribers_get_all_that_is_latched(opened, connect):
    publisher = opened(String, latch=True)
    early = connect(publisher, "/early")
    for words in (["left"], ["left", "right"]):
        publisher.latch_all([String(word) for word in words])
        publisher.publish(String(words[-1]))
    late = connect(publisher, "/late")
    publisher.latch_all([])
    publisher.publish(String("last"))
    assert [receive(early).data for _ in range(3)] == ["left", "right", "last"]
    assert [receive(late).data for _ in range(3)] == ["left", "right", "last"]
    assert receive(connect(publisher, "/latest")).data == "last"
