"""Answers to a board that asks for parameters; its link only keeps what is sent."""

import time
from typing import Any, Dict, List, Tuple, cast

import pytest

from serial_link.endpoints import ros_side
from serial_link.endpoints.ros_side import RosSide
from serial_link.host.counters import Counters
from serial_link.link.events import ParameterRequest, Restarted, Topics
from serial_link.negotiation.payloads import PARAMETER, decode_values

PARAMETERS: Dict[str, Any] = {"/a": 1, "/b": 2}
KNOWN = Topics([], True)


class Link:
    """Keeps the answers that a board would get."""

    def __init__(self) -> None:
        self.answers: List[Tuple[int, List[int]]] = []

    def answer(self, topic_id: int, payload: bytes) -> None:
        self.answers.append((topic_id, list(decode_values(payload).ints)))


class Scope:
    """Resolves names; the rest is not used."""

    name = "/node"

    def resolve(self, name: str) -> str:
        return "/" + name

    def create_publisher(self, *_arguments: Any) -> None:
        pass


@pytest.fixture
def link() -> Link:
    return Link()


@pytest.fixture
def side(link: Link) -> RosSide:
    return RosSide(
        cast(Any, Scope()), cast(Any, link), Counters(), lambda: 1.0, PARAMETERS.__getitem__
    )


def test_board_whose_topics_are_unknown_gets_an_answer_to_its_last_request_alone(
    side: RosSide, link: Link
) -> None:
    for name in ("a", "b"):
        side._handle(ParameterRequest(name, time.monotonic()))
    assert link.answers == []
    side._handle(KNOWN)
    assert link.answers == [(PARAMETER, [2])]
    side._handle(KNOWN)
    assert len(link.answers) == 1


def test_board_that_has_given_up_its_request_gets_no_answer(side: RosSide, link: Link) -> None:
    side._handle(ParameterRequest("a", time.monotonic() - 1.0))
    side._handle(KNOWN)
    side._handle(ParameterRequest("a", time.monotonic() - 1.0))
    side._handle(ParameterRequest("b", time.monotonic()))
    assert link.answers == [(PARAMETER, [2])]


def test_slow_master_leaves_a_request_without_an_answer(
    link: Link, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    def find(name: str) -> Any:
        monkeypatch.setattr(ros_side, "_ANSWER_S", 0.0)  # the time is over
        return PARAMETERS[name]

    side = RosSide(cast(Any, Scope()), cast(Any, link), Counters(), lambda: 1.0, find)
    side._handle(KNOWN)
    side._handle(ParameterRequest("a", time.monotonic()))
    assert link.answers == []


def test_request_of_a_board_that_was_restarted_is_forgotten(side: RosSide, link: Link) -> None:
    side._handle(ParameterRequest("a", time.monotonic()))
    side._handle(Restarted("the board was restarted"))
    side._handle(KNOWN)
    assert link.answers == []
