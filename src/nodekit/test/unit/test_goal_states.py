"""Tests of goal states and of a server's list of goals, with actionlib_msgs/GoalStatus."""

from typing import Dict, List, Set, Tuple

import hypothesis.strategies as st
import pytest
from actionlib_msgs.msg import GoalStatus
from hypothesis import given

from nodekit.actions.goal_list import LISTED_S, Goal, GoalList
from nodekit.actions.goal_states import (
    CANCELING,
    ENDED,
    RUNNING,
    TRANSITIONS,
    GoalEvent,
    GoalState,
    state_after,
)

#: From actionlib's description of a server's states, independent of the table.
ALLOWED: Dict[str, str] = {
    "PENDING": "accept ACTIVE, reject REJECTED, request_cancel RECALLING, cancel RECALLED",
    "RECALLING": "accept PREEMPTING, reject REJECTED, cancel RECALLED",
    "ACTIVE": "request_cancel PREEMPTING, cancel PREEMPTED, abort ABORTED, succeed SUCCEEDED",
    "PREEMPTING": "cancel PREEMPTED, abort ABORTED, succeed SUCCEEDED",
}
SECOND = 10**9


def allowed() -> Set[Tuple[str, str, str]]:
    return {
        (start, *move.split()) for start, moves in ALLOWED.items() for move in moves.split(", ")
    }


@pytest.mark.parametrize("state", GoalState)
def test_state_has_the_number_of_goal_status(state: GoalState) -> None:
    assert getattr(GoalStatus, state.name) == state


@pytest.mark.parametrize("event", GoalEvent)
@pytest.mark.parametrize("state", GoalState)
def test_each_event_in_each_state(state: GoalState, event: GoalEvent) -> None:
    after = state_after(state, event)
    moves = {(start, move): goal for start, move, goal in allowed()}
    assert (after.name if after is not None else None) == moves.get((state.name, event.value))


def test_states_are_ended_running_or_before() -> None:
    ended = {"PREEMPTED", "SUCCEEDED", "ABORTED", "REJECTED", "RECALLED", "LOST"}
    assert {state.name for state in ENDED} == ended
    assert {state.name for state in RUNNING} == {"ACTIVE", "PREEMPTING"}
    assert {state.name for state in CANCELING} == {"RECALLING", "PREEMPTING"}
    assert not any(start in ENDED for start, _ in TRANSITIONS)


@given(st.lists(st.sampled_from(GoalEvent), max_size=12))
def test_goal_ends_once_and_never_goes_back(events: List[GoalEvent]) -> None:
    goals = GoalList()
    goal = goals.add("a", 1, 1, 0.0).goal
    was_running = has_ended = was_cancelled = False
    for number, event in enumerate(events):
        before = goal.state
        changed = goals.apply(goal, event, str(number), float(number))
        assert changed == (goal.state is not before)
        assert not (has_ended and changed)
        assert goal.text == (str(number) if changed else goal.text)
        was_running = was_running or goal.state in RUNNING
        was_cancelled = was_cancelled or goal.state in CANCELING
        has_ended = goal.has_ended
        assert has_ended == (goal.state in ENDED) == (goal.ended_at is not None)
        assert not (was_running and goal.state in (GoalState.PENDING, GoalState.REJECTED))
        assert not (was_cancelled and goal.state in (GoalState.PENDING, GoalState.ACTIVE))


def listed(*stamps: int) -> Tuple[GoalList, List[Goal]]:
    """Return a list of active goals named 0, 1, …, sent at these times [s]."""
    goals = GoalList()
    made = [
        goals.add(str(number), stamp * SECOND, 100 * SECOND, 0.0).goal
        for number, stamp in enumerate(stamps)
    ]
    for goal in made:
        goals.apply(goal, GoalEvent.ACCEPT, "", 0.0)
    return goals, made


@pytest.mark.parametrize(
    ("id", "stamp", "cancelled"),
    [("", 0, "0123"), ("2", 0, "2"), ("", 20, "01"), ("3", 10, "03"), ("", 9, ""), ("x", 0, "")],
)
def test_cancellation_by_id_by_time_and_of_all(id: str, stamp: int, cancelled: str) -> None:
    goals, _ = listed(10, 20, 30, 40)
    found = goals.cancel(id, stamp * SECOND, 100 * SECOND, 0.0)
    assert "".join(goal.id for goal in found) == cancelled


def test_cancellation_leaves_goals_that_end_already() -> None:
    goals, (first, second, third) = listed(1, 2, 3)
    goals.apply(first, GoalEvent.SUCCEED, "", 0.0)
    goals.apply(second, GoalEvent.REQUEST_CANCEL, "", 0.0)
    assert goals.cancel("", 0, 100 * SECOND, 0.0) == [third]
    assert goals.cancel("0", 0, 100 * SECOND, 0.0) == []


def test_goal_cancelled_by_id_before_it_arrives_is_recalled_once() -> None:
    goals = GoalList()
    assert goals.cancel("early", 0, SECOND, 0.0) == []
    assert [(goal.id, goal.state) for goal in goals] == [("early", GoalState.RECALLING)]
    arrival = goals.add("early", 5, SECOND, 1.0)
    assert (arrival.is_new, arrival.is_recalled) == (False, True)
    assert arrival.goal.state is GoalState.RECALLED
    again = goals.add("early", 5, SECOND, 1.0)
    assert (again.is_new, again.is_recalled, again.goal) == (False, False, arrival.goal)


def test_goal_cancelled_by_time_before_it_arrives_is_recalled() -> None:
    goals = GoalList()
    goals.cancel("", 10 * SECOND, 20 * SECOND, 0.0)
    arrivals = [goals.add(str(stamp), stamp * SECOND, 20 * SECOND, 0.0) for stamp in (10, 11, 0)]
    assert [arrival.is_recalled for arrival in arrivals] == [True, False, False]
    assert [arrival.is_new for arrival in arrivals] == [False, True, True]
    assert [arrival.goal.stamp // SECOND for arrival in arrivals] == [10, 11, 20]


def test_cancellation_ahead_of_the_clock_is_for_goals_until_now() -> None:
    goals, (first,) = listed(5)
    assert goals.cancel("", 10**6 * SECOND, 100 * SECOND, 0.0) == [first]
    assert goals.add("later", 101 * SECOND, 101 * SECOND, 0.0).is_new


def test_clock_that_is_set_back_forgets_cancellations_by_time() -> None:
    goals = GoalList()
    goals.cancel("", 50 * SECOND, 50 * SECOND, 0.0)
    assert goals.add("a", 49 * SECOND, 51 * SECOND, 0.0).is_recalled
    assert goals.add("b", 1 * SECOND, 1 * SECOND, 0.0).is_new


def test_duplicate_of_a_running_goal_is_ignored() -> None:
    goals, (first,) = listed(1)
    arrival = goals.add("0", 7 * SECOND, 100 * SECOND, 0.0)
    assert arrival == (first, False, False)
    assert first.state is GoalState.ACTIVE


def test_ended_goals_are_listed_for_a_while() -> None:
    goals, (first, second) = listed(1, 2)
    goals.apply(first, GoalEvent.ABORT, "", 10.0)
    goals.drop_ended(10.0 + LISTED_S)
    assert [goal.id for goal in goals] == ["0", "1"]
    goals.drop_ended(10.1 + LISTED_S)
    assert [goal.id for goal in goals] == ["1"]
    assert second.state is GoalState.ACTIVE
