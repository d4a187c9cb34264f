"""Events of a board, handled by its ROS side: parameter requests, and refused services."""

import threading
import time
from typing import Any, Iterator, List, Tuple

import pytest
from std_msgs.msg import UInt32

from nodekit.testing.waiting import wait_until
from serial_link.endpoints.ros_side import RosSide
from serial_link.host.counters import MALFORMED, REFUSED, Counters
from serial_link.host.message_queue import MessageQueue
from serial_link.host.parameter_requests import ParameterRequests
from serial_link.link.events import Message, ParameterRequest, Restarted, Topics
from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    TopicInfo,
    decode_values,
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

    def __init__(self) -> None:
        self.inbox = MessageQueue()
        self.parameter_requests = ParameterRequests()
        self.topic_requests = 0
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
        pass

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

    def refused(self) -> int:
        return self.counters.to_dict().get(REFUSED, 0)


@pytest.fixture
def rig(monkeypatch: "pytest.MonkeyPatch") -> Iterator[Rig]:
    # On a busy machine, the answers may take long.
    monkeypatch.setattr("serial_link.host.parameter_requests.ANSWER_WITHIN_S", 60.0)
    rig = Rig()
    yield rig
    rig.side.close()


def test_only_the_last_parameter_request_before_the_topics_is_answered(rig: Rig) -> None:
    rig.context.request("first")
    rig.context.request("second")
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_for_answers("/second")
    rig.context.request("third")
    rig.wait_for_answers("/second", "/third")


def test_parameter_request_before_a_restart_is_not_answered(rig: Rig) -> None:
    rig.context.request("first")
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.request("second")
    rig.wait_for_answers("/second")


def test_parameter_request_after_a_restart_is_answered_once_the_topics_are_known(rig: Rig) -> None:
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.request("early")
    wait_until(lambda: rig.context.inbox.is_idle, lambda: "it is still at work")
    assert rig.context.answers == []
    rig.context.inbox.put_reliable(Topics([], True))
    rig.wait_for_answers("/early")


def test_parameter_whose_next_request_arrives_first_is_not_answered(rig: Rig) -> None:
    rig.context.inbox.put_reliable(Topics([], True))
    rig.context.request("slow")
    rig.wait_for_answers("/next")


@pytest.mark.parametrize(
    ("kind", "requests"), [(SERVICE_CLIENT, 1), (SERVICE_SERVER, 0), (PUBLISHER, 0)]
)
def test_only_a_call_of_a_refused_service_requests_the_topics(
    rig: Rig, kind: int, requests: int
) -> None:
    outgoing = None if kind == PUBLISHER else INFO
    endpoint = Endpoint(kind, INFO.name, INFO.type, INFO, outgoing)
    rig.context.inbox.put_reliable(Topics([endpoint], True))
    rig.context.inbox.put_reliable(Message(endpoint, b"x"))
    wait_until(rig.refused, lambda: f"{rig.counters.to_dict()}")
    rig.context.request("first")  # handled after the message
    rig.wait_for_answers("/first")
    assert (rig.refused(), rig.context.topic_requests) == (1, requests)


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
    wait_until(lambda: rig.context.inbox.is_idle, lambda: "it is still at work")
    assert not rig.context.receive_now(TOPIC, value(4))  # the board no longer publishes it


def test_topic_stays_open_after_a_restart_until_the_board_has_announced_all(rig: Rig) -> None:
    publish_first(rig)
    rig.context.inbox.put_reliable(Restarted("the board was restarted"))
    rig.context.inbox.put_reliable(Topics([], False))
    wait_until(lambda: rig.context.inbox.is_idle, lambda: "it is still at work")
    assert rig.context.receive_now(TOPIC, value(2))
    rig.context.inbox.put_reliable(Topics([], True))
    wait_until(lambda: rig.context.inbox.is_idle, lambda: "it is still at work")
    assert not rig.context.receive_now(TOPIC, value(3))


def test_message_does_not_overtake_an_unfinished_one(rig: Rig) -> None:
    publish_first(rig)
    rig.context.is_held.clear()
    rig.context.inbox.put(1, Message(TOPIC, value(2)))
    wait_until(lambda: len(rig.context.published) == 2, lambda: "nothing is published")
    assert not rig.context.receive_now(TOPIC, value(3))
    rig.context.is_held.set()


def test_faulty_messages_are_counted_or_logged_in_the_calling_thread(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    publish_first(rig)
    assert rig.context.receive_now(TOPIC, b"x")
    assert rig.counters.to_dict() == {MALFORMED: 1}
    assert rig.context.receive_now(TOPIC, value(FAILS))
    assert "RuntimeError: publishing failed" in caplog.text
    assert rig.context.receive_now(TOPIC, value(2))
