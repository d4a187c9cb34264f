"""Events of a board, handled by its ROS side: parameter requests, and refused services."""

import threading
import time
from typing import Any, Iterator, List, Tuple
from unittest import mock

import pytest
import rospy
from std_msgs.msg import UInt32

from nodekit.testing.waiting import wait_until
from serial_link.endpoints.ros_side import RosSide
from serial_link.host.counters import MALFORMED, REFUSED, Counters
from serial_link.host.message_queue import MessageQueue
from serial_link.host.parameter_requests import ParameterRequests
from serial_link.link.events import (
    LogLine,
    Message,
    ParameterRequest,
    Restarted,
    Synced,
    Topics,
)
from serial_link.negotiation.payloads import (
    WARN,
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    ParameterValues,
    TopicInfo,
    decode_values,
    encode_values,
)
from serial_link.negotiation.topic_table import Endpoint

INFO = TopicInfo(125, "strange", "no_such_msgs/Thing", "0" * 32, 280)
COUNT = TopicInfo(126, "count", UInt32._type, UInt32._md5sum, 280)
#: A topic that the board publishes, and a value that cannot be published.
TOPIC, FAILS = Endpoint(PUBLISHER, COUNT.name, COUNT.type, COUNT, None), 99


class FakeContext:
    """Scope and link of a board."""

    name = "/serial_node"
    trouble = ""
    baud = 0

    def __init__(self) -> None:
        self.inbox = MessageQueue()
        self.parameter_requests = ParameterRequests()
        self.topic_requests = self.closed = 0
        self.answers: List[str] = []
        #: Published values, each with its thread; publishing waits until ``is_held`` is set.
        self.published: List[Tuple[int, threading.Thread]] = []
        self.is_held = threading.Event()
        self.is_held.set()

    def create_scope(self) -> "FakeContext":
        return self

    def create_publisher(self, name: str, _class: Any, queue_size: int = 0) -> "FakeContext":
        assert name == "/rosout" or queue_size > 0  # otherwise publish() may wait for a subscriber
        return self

    def publish(self, message: Any) -> None:
        self.published.append((message.data, threading.current_thread()))
        if message.data == FAILS:
            raise RuntimeError("publishing failed")
        self.is_held.wait(30.0)

    def resolve(self, name: str) -> str:
        return "/" + name

    def close(self) -> None:
        self.closed += 1

    def request(self, name: str) -> None:
        number = self.parameter_requests.add(time.monotonic())
        self.inbox.put_reliable(ParameterRequest(name, number))

    def answer(self, topic_id: int, payload: bytes) -> None:
        self.answers += decode_values(payload).texts

    def request_topics(self) -> None:
        self.topic_requests += 1


class Rig:
    """A running ROS side. The value of a parameter is its name; ``slow`` is answered late."""

    def __init__(self) -> None:
        self.context: Any = FakeContext()
        self.counters = Counters()
        self.side = RosSide(self.context, self.context, self.counters, lambda: 5.0, self.find)
        self.side.start()

    def find(self, name: str) -> str:
        if name == "/slow":
            self.context.request("next")
        return name

    def wait_for_answers(self, *names: str) -> None:
        """Wait for these answers, and check that there are no others."""
        wait_until(
            lambda: self.context.answers[-1:] == [names[-1]], lambda: f"{self.context.answers}"
        )
        assert self.context.answers == list(names)

    def wait_until_idle(self) -> None:
        wait_until(lambda: self.context.inbox.is_idle, lambda: "it is still at work")

    def refused(self) -> int:
        return self.counters.to_dict().get(REFUSED, 0)


@pytest.fixture
def rig(monkeypatch: "pytest.MonkeyPatch") -> Iterator[Rig]:
    # On a busy machine, the answers may take long.
    monkeypatch.setattr("serial_link.host.parameter_requests.ANSWER_WITHIN_S", 60.0)
    rig = Rig()
    yield rig
    rig.side.close()


def test_only_the_last_parameter_request_before_the_topics_is_answered(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    rig.context.request("first")
    rig.context.request("second")
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_for_answers("/second")
    assert "the board's request for first is not answered" in caplog.text
    assert "request for second" not in caplog.text
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_until_idle()
    rig.context.request("third")
    rig.wait_for_answers("/second", "/third")


def test_parameter_request_before_a_restart_is_not_answered(rig: Rig) -> None:
    rig.context.request("first")
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_until_idle()
    rig.context.request("second")
    rig.wait_for_answers("/second")


def test_parameter_request_after_a_restart_is_answered_once_the_topics_are_known(rig: Rig) -> None:
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.request("early")
    rig.wait_until_idle()
    assert rig.context.answers == []
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_for_answers("/early")


def test_parameter_whose_next_request_arrives_first_is_not_answered(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.request("slow")
    rig.wait_for_answers("/next")
    assert "the board's request for slow is not answered: it may have timed out" in caplog.text


@pytest.mark.parametrize(
    ("kind", "requests"), [(SERVICE_CLIENT, 1), (SERVICE_SERVER, 0), (PUBLISHER, 0)]
)
def test_only_a_call_of_a_refused_service_requests_the_topics(
    rig: Rig, kind: int, requests: int, caplog: "pytest.LogCaptureFixture"
) -> None:
    outgoing = None if kind == PUBLISHER else INFO
    endpoint = Endpoint(kind, INFO.name, INFO.type, INFO, outgoing)
    rig.context.inbox.put_reliable(Topics([endpoint], True))
    rig.context.inbox.put_reliable(Message(endpoint, b"x"))
    wait_until(rig.refused, lambda: f"{rig.counters.to_dict()}")
    rig.context.request("first")  # handled after the message
    rig.wait_for_answers("/first")
    assert (rig.refused(), rig.context.topic_requests) == (1, requests)
    assert caplog.text.count("the board's calls end with an unchanged response") == requests
    assert rig.context.closed == 1


def value(number: int) -> bytes:
    return number.to_bytes(4, "little")


def publish_first(rig: Rig) -> None:
    """Send the first message of a topic, which opens the topic."""
    assert not rig.context.receive_now(TOPIC, value(1))
    rig.context.inbox.put(1, Message(TOPIC, value(1)))
    wait_until(
        lambda: rig.context.published and rig.context.inbox.is_idle, lambda: "nothing is published"
    )


def test_message_of_an_open_topic_is_published_in_the_calling_thread(rig: Rig) -> None:
    publish_first(rig)
    assert rig.context.receive_now(TOPIC, value(2))
    assert rig.context.published[1] == (2, threading.current_thread())
    moved = TOPIC._replace(incoming=COUNT._replace(topic_id=127))
    assert not rig.context.receive_now(moved, value(3))
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_until_idle()
    assert not rig.context.receive_now(TOPIC, value(4))  # the board no longer publishes it
    assert rig.context.closed == 1


def test_topic_stays_open_after_a_restart_until_the_board_has_announced_all(rig: Rig) -> None:
    publish_first(rig)
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.inbox.put_reliable(Topics([], False))
    rig.wait_until_idle()
    assert rig.context.receive_now(TOPIC, value(2))
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_until_idle()
    assert not rig.context.receive_now(TOPIC, value(3))


def test_message_does_not_overtake_an_unfinished_one(rig: Rig) -> None:
    publish_first(rig)
    rig.context.is_held.clear()
    rig.context.inbox.put(1, Message(TOPIC, value(2)))
    wait_until(lambda: len(rig.context.published) == 2, lambda: "nothing is published")
    assert not rig.context.receive_now(TOPIC, value(3))
    rig.context.is_held.set()


def test_faulty_messages_are_counted_or_logged_in_either_thread(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    publish_first(rig)
    rig.context.inbox.put(1, Message(TOPIC, b"x"))
    rig.wait_until_idle()
    assert rig.context.receive_now(TOPIC, b"x")
    assert rig.counters.to_dict() == {MALFORMED: 2}
    assert rig.context.receive_now(TOPIC, value(FAILS))
    assert "RuntimeError: publishing failed" in caplog.text
    assert rig.context.receive_now(TOPIC, value(2))


def test_exception_is_logged_and_the_next_event_handled(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    rig.context.inbox.put(1, Message(TOPIC, value(FAILS)))
    rig.wait_until_idle()
    assert "RuntimeError: publishing failed" in caplog.text
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.request("gain")
    rig.wait_for_answers("/gain")


def test_closed_side_no_longer_waits_for_events(rig: Rig) -> None:
    rig.side.close()
    assert rig.context.inbox.wait(0.0)
    wait_until(lambda: not rig.side._thread.is_alive(), lambda: "its thread runs")


class Left:
    """ROS side of the board "left", without a thread; its topics and services are mocks."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.scope, self.link = mock.Mock(), mock.Mock()
        self.scope.name = "/serial_node"
        self.link.baud = 0
        self.scope.resolve = lambda name: "/" + name
        self.find = mock.Mock(return_value="text")
        self.side = RosSide(self.scope, self.link, Counters(), lambda: 5.0, self.find, "left")
        self.create = mock.Mock()
        monkeypatch.setattr(self.side, "_create", self.create)
        self.handle = self.side._handle

    def announce(self, *endpoints: Endpoint, is_complete: bool = True) -> None:
        self.handle(Topics(list(endpoints), is_complete))

    def created(self) -> List[str]:
        return [call[0][1].name for call in self.create.call_args_list]


@pytest.fixture
def left(monkeypatch: "pytest.MonkeyPatch") -> Left:
    return Left(monkeypatch)


def test_log_and_topics_of_a_named_board_are_in_its_namespace(
    left: Left, caplog: "pytest.LogCaptureFixture", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(rospy, "get_rostime", lambda: rospy.Time(12))
    caplog.set_level("INFO", "rosout")
    left.handle(LogLine(WARN, "hot"))
    publish = left.scope.create_publisher.return_value.publish
    assert publish.call_args[0][0].name == "/serial_node/left"
    left.announce(TOPIC, TOPIC._replace(name="/global"))
    assert left.created() == ["left/count", "/global"]
    assert "the board publishes left/count (std_msgs/UInt32)" in caplog.text
    left.announce()
    assert "the board no longer publishes left/count" in caplog.text


@pytest.mark.parametrize(
    ("kind", "verb"),
    [
        (PUBLISHER, "publishes"),
        (SUBSCRIBER, "subscribes to"),
        (SERVICE_SERVER, "offers"),
        (SERVICE_CLIENT, "calls"),
    ],
)
def test_log_tells_what_the_board_does_with_a_topic_or_service(
    left: Left, kind: int, verb: str, caplog: "pytest.LogCaptureFixture"
) -> None:
    caplog.set_level("INFO", "rosout")
    left.announce(Endpoint(kind, "zero", "std_srvs/Trigger", COUNT, COUNT))
    left.announce()
    assert caplog.messages == [
        f"the board {verb} left/zero (std_srvs/Trigger)",
        f"the board no longer {verb} left/zero",
    ]


@pytest.mark.parametrize(
    ("name", "resolved"), [("gain", "/left/gain"), ("~gain", "/~gain"), ("/gain", "//gain")]
)
def test_parameter_of_a_named_board_is_in_its_namespace_unless_private_or_global(
    left: Left, name: str, resolved: str
) -> None:
    left.announce()
    left.handle(ParameterRequest(name, 1))
    left.find.assert_called_once_with(resolved)


def test_parameter_is_answered_empty_if_the_master_does_not_answer_or_a_buffer_is_too_small(
    left: Left, caplog: "pytest.LogCaptureFixture"
) -> None:
    small = TOPIC._replace(kind=SUBSCRIBER, incoming=None, outgoing=COUNT._replace(buffer_size=15))
    large = small._replace(name="large", outgoing=COUNT._replace(topic_id=100))
    left.announce(small, large)
    left.handle(ParameterRequest("long", 1))
    left.find.side_effect = ConnectionError("no master")
    left.handle(ParameterRequest("gain", 2))
    empty = encode_values(ParameterValues())
    assert [call[0][1] for call in left.link.answer.call_args_list] == [empty, empty]
    assert "the board's buffer has 15" in caplog.text
    assert "asks for gain: no master" in caplog.text


def test_answer_that_takes_longer_than_the_library_waits_is_logged_and_sent(
    left: Left, caplog: "pytest.LogCaptureFixture"
) -> None:
    left.announce()
    left.link.baud = 57600
    left.find.return_value = [0] * 11
    left.handle(ParameterRequest("short", 1))
    assert not caplog.text
    left.find.return_value = [0] * 12  # as ints and as floats
    left.handle(ParameterRequest("long", 2))
    assert "the board asks for long: 108 bytes take longer than the 20 ms" in caplog.text
    assert [len(call[0][1]) for call in left.link.answer.call_args_list] == [100, 108]


def test_new_ids_and_the_reason_of_a_loss_reach_an_open_topic(left: Left) -> None:
    left.announce(TOPIC)
    moved = TOPIC._replace(incoming=COUNT._replace(topic_id=127))
    left.announce(moved)
    left.create.return_value.update.assert_called_with(moved)
    left.handle(Restarted("the cable is out"))
    left.create.return_value.on_lost.assert_called_once_with("the cable is out")
    assert left.created() == ["left/count"]


def test_two_subscribers_of_one_topic_keep_their_ids_in_any_order(left: Left) -> None:
    first, second = (
        Endpoint(SUBSCRIBER, COUNT.name, COUNT.type, None, COUNT._replace(topic_id=number))
        for number in (100, 101)
    )
    topics = left.create.side_effect = [mock.Mock(), mock.Mock()]
    left.announce(first, second)
    left.announce(second, first)
    for topic, endpoint in zip(topics, (first, second)):
        topic.update.assert_called_once_with(endpoint)


@pytest.mark.parametrize("half", ["incoming", "outgoing"])
def test_topic_whose_definition_the_new_sketch_changes_is_opened_again(
    left: Left, half: str
) -> None:
    service = Endpoint(SERVICE_SERVER, "zero", "std_srvs/Trigger", COUNT, COUNT)
    left.announce(service)
    left.announce(service._replace(**{half: COUNT._replace(md5sum="1" * 32)}))
    assert left.create.call_count == 2
    assert left.scope.create_scope.return_value.close.call_count == 1


def test_all_topics_are_told_that_the_board_is_synced_or_lost(left: Left) -> None:
    left.announce(TOPIC, TOPIC._replace(name="other"))
    left.handle(Restarted("the cable is out"))
    left.announce(TOPIC, TOPIC._replace(name="other"))
    left.handle(Synced())
    topic = left.create.return_value
    assert (topic.on_sync.call_count, topic.on_lost.call_count) == (2, 2)


def test_topic_that_is_open_before_the_board_is_synced_alone_is_told(left: Left) -> None:
    first, second = left.create.side_effect = [mock.Mock(), mock.Mock()]
    left.announce(TOPIC, is_complete=False)  # a message may have been lost since
    left.announce(TOPIC, TOPIC._replace(name="other"))
    left.handle(Synced())
    assert (first.on_sync.call_count, second.on_sync.call_count) == (1, 0)


def test_topic_of_another_type_and_name_stays_open_until_all_are_announced(left: Left) -> None:
    left.announce(TOPIC)
    left.handle(Restarted("the board was restarted"))
    other = TOPIC._replace(name="other", type="std_msgs/Bool")
    left.announce(other, is_complete=False)
    assert not left.scope.create_scope.return_value.close.called
    left.handle(Restarted("the board was restarted"))
    left.announce(TOPIC._replace(type="std_msgs/Bool"), is_complete=False)  # the same name
    assert left.scope.create_scope.return_value.close.called


def test_service_and_topic_of_one_name_displace_no_other(left: Left) -> None:
    left.announce(TOPIC)
    left.handle(Restarted("the board was restarted"))
    service = Endpoint(SERVICE_SERVER, TOPIC.name, "std_srvs/Trigger", COUNT, COUNT)
    left.announce(service, is_complete=False)
    assert not left.scope.create_scope.return_value.close.called


def test_topic_that_cannot_be_opened_is_closed_and_retried_after_a_pause(left: Left) -> None:
    left.create.side_effect = RuntimeError("no more descriptors")
    with pytest.raises(RuntimeError):
        left.announce(TOPIC)
    with pytest.raises(RuntimeError):
        left.handle(None)
    left.handle(None)
    assert left.scope.create_scope.return_value.close.call_count == 2


def test_topic_that_ros_refuses_is_named(left: Left, caplog: "pytest.LogCaptureFixture") -> None:
    left.create.side_effect = rospy.ROSException("it has another type in this node")
    left.announce(TOPIC)
    assert "left/count is refused: it has another type in this node" in caplog.text


def test_topic_of_the_board_with_an_invalid_buffer_is_refused(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    outgoing = COUNT._replace(buffer_size=0)
    endpoint = TOPIC._replace(kind=SUBSCRIBER, incoming=None, outgoing=outgoing)
    rig.side._handle(Topics([endpoint], True))
    assert "count is refused: its buffer has 0 bytes" in caplog.text
