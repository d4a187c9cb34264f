"""Events of a board, handled by its ROS side: parameter requests, and refused services."""

import time
from typing import Any, Iterator, List

import pytest

from nodekit.testing.waiting import wait_until
from serial_link.endpoints.ros_side import RosSide
from serial_link.host.counters import REFUSED, Counters
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


class FakeContext:
    """Scope and link of a board."""

    name = "/serial_node"
    trouble = ""

    def __init__(self) -> None:
        self.inbox = MessageQueue()
        self.parameter_requests = ParameterRequests()
        self.topic_requests = 0
        self.answers: List[str] = []

    def create_scope(self) -> "FakeContext":
        return self

    def create_publisher(self, *arguments: Any) -> "FakeContext":
        return self

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
