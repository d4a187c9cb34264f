"""The states of a goal in either ROS, and their translation."""

from typing import List, Set

import pytest

from ros2_bridge.actions.states import (
    ROS1_TERMINAL,
    ROS2_TERMINAL,
    ROS1_TRANSITIONS,
    ROS2_TRANSITIONS,
    TO_ROS1,
    TO_ROS2,
    Ros1Status,
    Ros2Status,
    matches_cancel_request,
    nearest,
)

P, A, R = Ros1Status.PENDING, Ros1Status.ACTIVE, Ros1Status.RECALLING


def test_each_state_is_translated() -> None:
    assert set(TO_ROS2) == set(Ros1Status)
    assert set(TO_ROS1) == set(Ros2Status)
    assert {one for many in TO_ROS1.values() for one in many} == set(Ros1Status) - {
        Ros1Status.REJECTED,  # is the answer to a goal in ROS 2
        Ros1Status.LOST,  # is what a client of ROS 1 finds by itself
    }


@pytest.mark.parametrize("status", sorted(Ros1Status))
def test_final_states_are_final_in_both(status: Ros1Status) -> None:
    assert (status in ROS1_TERMINAL) == (TO_ROS2[status] in ROS2_TERMINAL)
    if status not in (Ros1Status.REJECTED, Ros1Status.LOST):
        assert status in TO_ROS1[TO_ROS2[status]]


def test_ros1_transitions_are_valid_in_ros2() -> None:
    assert ROS1_TRANSITIONS and ROS2_TRANSITIONS
    for before, afters in ROS1_TRANSITIONS.items():
        for after in afters:
            wanted = [TO_ROS2[after]]
            assert nearest(ROS2_TRANSITIONS, TO_ROS2[before], wanted) in wanted, (before, after)


@pytest.mark.parametrize(
    "before, after",  # as in actionlib's description of the server's states
    [
        *[(P, A), (P, R), (P, Ros1Status.RECALLED), (P, Ros1Status.REJECTED)],
        *[(R, Ros1Status.PREEMPTING), (R, Ros1Status.RECALLED), (R, Ros1Status.REJECTED)],
        *[(A, Ros1Status.PREEMPTING), (A, Ros1Status.PREEMPTED)],
        *[(A, Ros1Status.SUCCEEDED), (A, Ros1Status.ABORTED)],
        *[(Ros1Status.PREEMPTING, Ros1Status.PREEMPTED)],
        *[(Ros1Status.PREEMPTING, Ros1Status.SUCCEEDED)],
        *[(Ros1Status.PREEMPTING, Ros1Status.ABORTED)],
    ],
)
def test_transitions_of_actionlib(before: Ros1Status, after: Ros1Status) -> None:
    assert nearest(ROS1_TRANSITIONS, before, [after]) == after  # in one step


def test_ros2_transitions_are_valid_in_ros1() -> None:
    assert ROS2_TRANSITIONS
    for before, afters in ROS2_TRANSITIONS.items():
        for now in TO_ROS1[before]:
            for after in afters:
                assert nearest(ROS1_TRANSITIONS, now, TO_ROS1[after]) in TO_ROS1[after], (
                    now,
                    after,
                )


@pytest.mark.parametrize(
    "news, from_pending, from_active, from_recalling",
    [
        (Ros2Status.ACCEPTED, P, A, R),
        (Ros2Status.EXECUTING, A, A, R),
        (Ros2Status.CANCELING, R, Ros1Status.PREEMPTING, R),
        (Ros2Status.SUCCEEDED, Ros1Status.SUCCEEDED, Ros1Status.SUCCEEDED, Ros1Status.SUCCEEDED),
        (Ros2Status.CANCELED, Ros1Status.RECALLED, Ros1Status.PREEMPTED, Ros1Status.RECALLED),
        (Ros2Status.ABORTED, Ros1Status.ABORTED, Ros1Status.ABORTED, Ros1Status.ABORTED),
        (Ros2Status.UNKNOWN, Ros1Status.ABORTED, Ros1Status.ABORTED, Ros1Status.ABORTED),
    ],
)
def test_ros2_update_depends_on_previous_state(
    news: Ros2Status, from_pending: Ros1Status, from_active: Ros1Status, from_recalling: Ros1Status
) -> None:
    found = [nearest(ROS1_TRANSITIONS, now, TO_ROS1[news]) for now in (P, A, R)]
    assert found == [from_pending, from_active, from_recalling]


@pytest.mark.parametrize("last", sorted(ROS2_TERMINAL))
def test_final_states_have_no_transitions(last: Ros2Status) -> None:
    assert {nearest(ROS2_TRANSITIONS, last, [news]) for news in Ros2Status} == {last}


def test_states_have_the_numbers_of_the_messages() -> None:
    def names(status: type) -> List[str]:
        return [one.name for one in sorted(status)]  # type: ignore[call-overload]

    numbers: Set[int] = {int(one) for one in Ros1Status}
    assert numbers == set(range(10))
    assert names(Ros1Status)[2:6] == ["PREEMPTED", "SUCCEEDED", "ABORTED", "REJECTED"]
    assert names(Ros2Status)[1:6] == ["ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED"]


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
    assert not matches_cancel_request("in simulated time", 0, "x", 0)
