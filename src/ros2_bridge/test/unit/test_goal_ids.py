"""Ids of goals in either ROS."""

import uuid

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of


@given(st.binary(min_size=16, max_size=16))
def test_ros2_id_survives_round_trip(goal_id: bytes) -> None:
    assert bytes_of(text_of(goal_id)) == goal_id


@given(st.lists(st.text(), unique=True))
def test_ros1_ids_remain_distinct(texts: "list[str]") -> None:
    assert len({bytes_of(text) for text in texts}) == len(texts)


@given(st.text(min_size=1))
def test_id_of_ros1_is_that_of_a_goal(text: str) -> None:
    assert bytes_of(text) != NO_GOAL
    assert bytes_of(text) == bytes_of(text)


def test_no_goal_is_no_goal() -> None:
    assert (text_of(NO_GOAL), bytes_of("")) == ("", NO_GOAL)


@pytest.mark.parametrize("change", [str.upper, "{{{}}}".format, "urn:uuid:{}".format])
def test_different_spelling_is_different_goal(change: "type") -> None:
    one = uuid.UUID(int=0xABCDEF)
    assert bytes_of(str(one)) == one.bytes
    assert bytes_of(change(str(one))) != one.bytes
    assert bytes_of(str(uuid.UUID(int=0))) != NO_GOAL
