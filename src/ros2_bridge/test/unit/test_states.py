"""The states of a goal in either ROS, and their translation."""

from typing import List, Set

import pytest

from ros2_bridge.actions.states import (
    OVER1,
    OVER2,
    STEPS1,
    STEPS2,
    TO_ROS1,
    TO_ROS2,
    Status1,
    Status2,
    matches_cancel_request,
    nearest,
)

P, A, R = Status1.PENDING, Status1.ACTIVE, Status1.RECALLING


def test_each_state_is_translated() -> None:
    assert set(TO_ROS2) == set(Status1)
    assert set(TO_ROS1) == set(Status2)
    assert {one for many in TO_ROS1.values() for one in many} == set(Status1) - {
        Status1.REJECTED,  # is the answer to a goal in ROS 2
        Status1.LOST,  # is what a client of ROS 1 finds by itself
    }


@pytest.mark.parametrize("status", sorted(Status1))
def test_final_states_are_final_in_both(status: Status1) -> None:
    assert (status in OVER1) == (TO_ROS2[status] in OVER2)
    if status not in (Status1.REJECTED, Status1.LOST):
        assert status in TO_ROS1[TO_ROS2[status]]


def test_ros1_transitions_are_valid_in_ros2() -> None:
    assert STEPS1 and STEPS2
    for before, afters in STEPS1.items():
        for after in afters:
            wanted = [TO_ROS2[after]]
            assert nearest(STEPS2, TO_ROS2[before], wanted) in wanted, (before, after)


def test_ros2_transitions_are_valid_in_ros1() -> None:
    assert STEPS2
    for before, afters in STEPS2.items():
        for now in TO_ROS1[before]:
            for after in afters:
                assert nearest(STEPS1, now, TO_ROS1[after]) in TO_ROS1[after], (now, after)


@pytest.mark.parametrize(
    "news, from_pending, from_active, from_recalling",
    [
        (Status2.ACCEPTED, P, A, R),
        (Status2.EXECUTING, A, A, R),
        (Status2.CANCELING, R, Status1.PREEMPTING, R),
        (Status2.SUCCEEDED, Status1.SUCCEEDED, Status1.SUCCEEDED, Status1.SUCCEEDED),
        (Status2.CANCELED, Status1.RECALLED, Status1.PREEMPTED, Status1.RECALLED),
        (Status2.ABORTED, Status1.ABORTED, Status1.ABORTED, Status1.ABORTED),
        (Status2.UNKNOWN, Status1.ABORTED, Status1.ABORTED, Status1.ABORTED),
    ],
)
def test_ros2_update_depends_on_previous_state(
    news: Status2, from_pending: Status1, from_active: Status1, from_recalling: Status1
) -> None:
    found = [nearest(STEPS1, now, TO_ROS1[news]) for now in (P, A, R)]
    assert found == [from_pending, from_active, from_recalling]


@pytest.mark.parametrize("last", sorted(OVER2))
def test_final_states_have_no_transitions(last: Status2) -> None:
    assert {nearest(STEPS2, last, [news]) for news in Status2} == {last}


def test_states_have_the_numbers_of_the_messages() -> None:
    def names(status: type) -> List[str]:
        return [one.name for one in sorted(status)]  # type: ignore[call-overload]

    numbers: Set[int] = {int(one) for one in Status1}
    assert numbers == set(range(10))
    assert names(Status1)[2:6] == ["PREEMPTED", "SUCCEEDED", "ABORTED", "REJECTED"]
    assert names(Status2)[1:6] == ["ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED"]


@pytest.mark.parametrize(
    "wanted, until, meant",
    [
        ("", 0, ["a", "b", "c"]),
        ("b", 0, ["b"]),
        ("", 1, ["a"]),
        ("", 2, ["a", "b"]),
        ("c", 1, ["a", "c"]),
        ("x", 0, []),
        ("x", 2, ["a", "b"]),
    ],
)
def test_goals_are_meant_by_id_and_by_time(wanted: str, until: int, meant: "list[str]") -> None:
    stamps = {"a": 1, "b": 2, "c": 3}
    assert [
        one for one in stamps if matches_cancel_request(one, stamps[one], wanted, until)
    ] == meant
