"""The goals of a server of ROS 2, as clients of ROS 1 see them."""

from typing import Any, Dict, List, Optional, Sequence, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of
from ros2_bridge.actions.ros2_goal_tracker import (
    GONE,
    LISTED_S,
    NO_ANSWER,
    NO_END,
    NO_RESULT,
    RECALLED,
    REJECTED,
    Goal,
    Ros2GoalTracker,
    TimedOutGoals,
)
from ros2_bridge.actions.states import (
    ROS1_TERMINAL,
    ROS2_TERMINAL,
    RESULT_S,
    ROS1_TRANSITIONS,
    Ros1Status,
    Ros2Status,
    nearest,
)

ONE, TWO = "/node-1-7.5", "/node-2-7.5"
PATIENCE_S = 1.5
SENDER, OTHER = b"s" * 16, b"o" * 16
NOTHING = TimedOutGoals([], [])


class Clients:
    """Recorder of the messages to the clients of ROS 1."""

    def __init__(self) -> None:
        self.patience = PATIENCE_S
        self.goals = Ros2GoalTracker(lambda: self.patience, self._end, self._publish)
        self.status: Dict[str, Ros1Status] = {}
        self.results: List[Tuple[str, Ros1Status, str, Optional[bytes]]] = []

    def _publish(self, goals: Sequence[Goal]) -> None:
        self.status, before = {}, self.status
        for goal in goals:
            self.status[goal.text] = goal.status
            first = before.get(goal.text, Ros1Status.PENDING)
            reached = nearest(ROS1_TRANSITIONS, first, [goal.status]) == goal.status
            assert reached or goal.is_awaited, (first, goal.status)

    def _end(self, goal: Goal, result: Optional[bytes]) -> None:
        self.results.append((goal.text, goal.status, goal.why, result))

    def send(self, text: str, stamp: int = 1, now: float = 0.0) -> Optional[bytes]:
        return self.goals.request_goal(text, stamp, now)

    def answer(self, text: str, is_accepted: bool = True) -> bool:
        return self.goals.on_goal_response(bytes_of(text), is_accepted, 0.0)

    def list_goals(
        self, sender: bytes = SENDER, now: float = 0.0, **status: Ros2Status
    ) -> List[bytes]:
        uuids = {"one": bytes_of(ONE), "two": bytes_of(TWO), "theirs": b"t" * 16}
        listed = [(uuids[name], 1, one) for name, one in status.items()]
        return self.goals.on_status(listed, sender, now)

    def end(self, text: str, status: Ros2Status, result: bytes = b"far") -> None:
        self.goals.on_result(bytes_of(text), status, result, 0.0)


@pytest.fixture
def clients() -> Clients:
    return Clients()


def test_goal_goes_from_sending_to_its_result(clients: Clients) -> None:
    assert clients.send(ONE) == bytes_of(ONE)
    assert clients.status == {ONE: Ros1Status.PENDING}
    assert clients.answer(ONE) is False
    clients.list_goals(one=Ros2Status.EXECUTING)
    assert clients.status == {ONE: Ros1Status.ACTIVE}
    clients.list_goals(one=Ros2Status.SUCCEEDED)
    assert clients.status == {ONE: Ros1Status.ACTIVE} and not clients.results
    clients.end(ONE, Ros2Status.SUCCEEDED)
    assert clients.results == [(ONE, Ros1Status.SUCCEEDED, "", b"far")]
    assert clients.status == {ONE: Ros1Status.SUCCEEDED}
    clients.end(ONE, Ros2Status.ABORTED)
    clients.list_goals(one=Ros2Status.EXECUTING)
    assert len(clients.results) == 1 and clients.status == {ONE: Ros1Status.SUCCEEDED}
    assert clients.send(ONE) is None


def test_rejected_goal_says_why(clients: Clients) -> None:
    clients.send(ONE)
    clients.answer(ONE, False)
    clients.send(TWO)
    clients.goals.on_goal_response(bytes_of(TWO), False, 0.0, "not there")
    assert clients.results == [
        (ONE, Ros1Status.REJECTED, REJECTED, None),
        (TWO, Ros1Status.REJECTED, "not there", None),
    ]


def test_goal_that_the_server_does_not_answer_is_rejected(clients: Clients) -> None:
    clients.send(ONE)
    clients.send(TWO, now=1.0)
    clients.goals.request_cancel(ONE, 0, 0.0)
    assert clients.goals.end_timeouts(PATIENCE_S) == NOTHING and not clients.results
    assert clients.goals.end_timeouts(PATIENCE_S + 0.1) == NOTHING
    assert clients.results == [(ONE, Ros1Status.REJECTED, NO_ANSWER, None)]
    assert clients.status == {ONE: Ros1Status.REJECTED, TWO: Ros1Status.PENDING}
    assert clients.answer(ONE) is True  # accepted after all: it is to be cancelled
    assert clients.goals.end_timeouts(PATIENCE_S + 1.1) == NOTHING
    assert clients.results[1:] == [(TWO, Ros1Status.REJECTED, NO_ANSWER, None)]


def test_goal_that_is_listed_without_an_answer_is_accepted(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros2Status.EXECUTING)
    assert clients.goals.request_cancel(ONE, 0, 0.0) == []
    assert clients.goals.end_timeouts(PATIENCE_S) == NOTHING
    (goal,), _ = clients.goals.end_timeouts(PATIENCE_S + 0.1)
    assert goal.uuid == bytes_of(ONE) and goal.is_to_be_cancelled
    assert clients.goals.end_timeouts(PATIENCE_S + 0.2) == NOTHING and not clients.results
    assert clients.goals.request_cancel(ONE, 0, 0.0) == [bytes_of(ONE)]


@pytest.mark.parametrize("is_answered", (True, False))
def test_ended_goal_without_result_times_out(clients: Clients, is_answered: bool) -> None:
    for text in (ONE, TWO):
        clients.send(text)
        if is_answered:
            clients.answer(text)
    clients.list_goals(
        one=Ros2Status.SUCCEEDED, two=Ros2Status.SUCCEEDED, theirs=Ros2Status.EXECUTING
    )
    clients.list_goals(one=Ros2Status.SUCCEEDED, now=0.5)  # the wait began before
    clients.list_goals()  # the server keeps it for less long than we wait
    assert clients.goals.end_timeouts(RESULT_S) == NOTHING and not clients.results
    clients.end(TWO, Ros2Status.SUCCEEDED)
    ((goal,),) = [waited for waited in clients.goals.end_timeouts(RESULT_S + 0.1) if waited]
    assert goal.text == ONE
    assert clients.results[1:] == [(ONE, Ros1Status.SUCCEEDED, NO_RESULT, None)]
    assert clients.goals.end_timeouts(10.0) == NOTHING
    clients.end(ONE, Ros2Status.ABORTED)
    assert len(clients.results) == 2


def test_result_may_take_as_long_as_an_answer(clients: Clients) -> None:
    clients.patience = 2.0 * RESULT_S
    clients.send(ONE)
    clients.answer(ONE)
    clients.list_goals(one=Ros2Status.SUCCEEDED)
    assert clients.goals.end_timeouts(2.0 * RESULT_S) == NOTHING


def test_goal_that_is_rejected_once_it_was_listed_is_aborted(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros2Status.EXECUTING)
    clients.answer(ONE, False)
    assert clients.results == [(ONE, Ros1Status.ABORTED, REJECTED, None)]


@pytest.mark.parametrize("is_active", [True, False])
def test_cancelled_goal_is_preempted_or_recalled(clients: Clients, is_active: bool) -> None:
    clients.send(ONE)
    clients.answer(ONE)
    clients.list_goals(one=Ros2Status.EXECUTING if is_active else Ros2Status.ACCEPTED)
    assert clients.goals.request_cancel(ONE, 0, 0.0) == [bytes_of(ONE)]
    clients.list_goals(one=Ros2Status.CANCELING)
    first = Ros1Status.PREEMPTING if is_active else Ros1Status.RECALLING
    assert clients.status == {ONE: first}
    clients.end(ONE, Ros2Status.CANCELED)
    last = Ros1Status.PREEMPTED if is_active else Ros1Status.RECALLED
    assert clients.results == [(ONE, last, "", b"far")]


def test_cancellation_waits_for_the_answer(clients: Clients) -> None:
    clients.send(ONE)
    assert clients.goals.request_cancel(ONE, 0, 0.0) == []
    assert clients.answer(ONE) is True


def test_cancellation_that_overtakes_its_goal_recalls_it(clients: Clients) -> None:
    assert clients.goals.request_cancel(ONE, 0, 0.0) == []
    assert clients.status == {ONE: Ros1Status.RECALLING}
    assert clients.send(ONE) is None
    assert clients.results == [(ONE, Ros1Status.RECALLED, RECALLED, None)]
    assert not clients.answer(ONE, False)


def test_cancellation_that_overtakes_the_servers_list_is_passed_on(clients: Clients) -> None:
    clients.goals.request_cancel(ONE, 0, 0.0)  # a previous bridge has sent the goal
    assert clients.list_goals(one=Ros2Status.EXECUTING) == [bytes_of(ONE)]
    assert clients.status == {ONE: Ros1Status.RECALLING}
    assert clients.list_goals(one=Ros2Status.CANCELING) == []
    clients.list_goals(one=Ros2Status.CANCELED)
    assert clients.status == {ONE: Ros1Status.RECALLED} and not clients.results


def test_cancellation_is_not_kept_for_ever(clients: Clients) -> None:
    clients.goals.request_cancel(ONE, 0, 0.0)
    clients.goals.remove_old(LISTED_S + 0.1)
    clients.status.clear()
    assert clients.send(ONE) == bytes_of(ONE)


def test_goals_until_a_time_are_cancelled_even_if_late(clients: Clients) -> None:
    for stamp, text in enumerate((ONE, TWO), start=1):
        clients.send(text, stamp)
        clients.answer(text)
    assert clients.goals.request_cancel("", 1, 0.0) == [bytes_of(ONE)]
    assert clients.goals.request_cancel("", 2, 0.0) == [bytes_of(ONE), bytes_of(TWO)]
    assert clients.goals.request_cancel("", 1, 0.0) == [bytes_of(ONE)]  # the later time holds
    assert clients.send("late", 2) is None
    assert clients.results == [("late", Ros1Status.RECALLED, RECALLED, None)]
    assert clients.send("later", 3) is not None
    assert clients.send("without a time", 0) is not None


def test_all_goals_are_cancelled_by_one_request(clients: Clients) -> None:
    clients.send(ONE)
    assert clients.goals.request_cancel("", 0, 0.0) == [NO_GOAL]
    assert clients.answer(ONE) is True


def test_goals_of_ros2_are_listed_too(clients: Clients) -> None:
    theirs = text_of(b"t" * 16)
    clients.list_goals(theirs=Ros2Status.EXECUTING)
    assert clients.status == {theirs: Ros1Status.ACTIVE}
    assert clients.goals.request_cancel(theirs, 0, 0.0) == [b"t" * 16]
    assert clients.goals.under_way(b"t" * 16) is not None
    clients.list_goals(now=3.0, theirs=Ros2Status.SUCCEEDED)
    assert clients.status == {theirs: Ros1Status.SUCCEEDED} and not clients.results
    assert clients.goals.under_way(b"t" * 16) is None
    clients.goals.remove_old(3.0 + LISTED_S)
    assert clients.goals.listed()
    clients.goals.remove_old(3.1 + LISTED_S)
    clients.list_goals(theirs=Ros2Status.SUCCEEDED)
    assert clients.status == {}


def test_goal_of_ros1_is_cancelled_by_its_own_id_by_a_bridge_that_did_not_see_it(
    clients: Clients,
) -> None:
    clients.list_goals(one=Ros2Status.EXECUTING, two=Ros2Status.EXECUTING)
    assert clients.goals.request_cancel(ONE, 0, 0.0) == [bytes_of(ONE)]


def test_goals_of_lost_server_are_aborted(clients: Clients) -> None:
    clients.send(ONE)
    clients.send(TWO)
    clients.answer(ONE)
    clients.list_goals(one=Ros2Status.EXECUTING)
    clients.goals.abort_goals({SENDER}, 0.0)
    assert not clients.results and clients.goals.is_any_under_way()
    clients.goals.abort_goals({OTHER}, 0.0)  # a new server that knows neither goal
    assert clients.results == [(one, Ros1Status.ABORTED, GONE, None) for one in (ONE, TWO)]
    assert not clients.goals.is_any_under_way()
    assert clients.answer(TWO) is True  # accepted after all: it is to be cancelled
    assert clients.answer(TWO, False) is False


def test_goal_is_that_of_the_server_that_lists_it(clients: Clients) -> None:
    clients.list_goals(SENDER, theirs=Ros2Status.EXECUTING)
    clients.goals.abort_goals({SENDER, OTHER}, 0.0)
    assert clients.goals.is_any_under_way()
    clients.goals.abort_goals({OTHER}, 0.0)
    assert not clients.goals.is_any_under_way()


def test_goal_during_server_lookup_continues(clients: Clients) -> None:
    clients.send(ONE, now=1.1)
    clients.goals.abort_goals(set(), 1.0)
    assert not clients.results
    clients.goals.abort_goals({SENDER}, 1.2)
    clients.goals.abort_goals(set(), 1.3)
    assert clients.results == [(ONE, Ros1Status.ABORTED, GONE, None)]


def test_goal_that_the_server_has_forgotten_is_aborted(clients: Clients) -> None:
    clients.send(ONE)
    clients.answer(ONE)
    clients.end(ONE, Ros2Status.UNKNOWN)
    assert clients.results == [(ONE, Ros1Status.ABORTED, NO_END, b"far")]


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["send", "accept", "reject", "cancel", "status", "end", "wait"]),
        st.sampled_from([ONE, TWO]),
        st.lists(st.sampled_from(Ros2Status), min_size=3, max_size=3),
        st.floats(0.0, 2.0),
    ),
    max_size=30,
)


@given(EVENTS)
def test_each_goal_has_one_result(events: List[Any]) -> None:
    clients, now = Clients(), 0.0
    sent: List[str] = []
    for what, text, (one, two, theirs), pause in events:
        now += pause
        known = {goal.uuid for goal in clients.goals.listed() if not goal.is_awaited}
        if what == "send" and text not in sent and bytes_of(text) not in known:
            sent.append(text)
            clients.send(text, 1, now)
        elif what in ("accept", "reject"):
            clients.answer(text, what == "accept")
        elif what == "cancel":
            clients.goals.request_cancel(text, 0, now)
        elif what == "status":
            clients.list_goals(one=one, two=two, theirs=theirs)
        elif what == "end" and one in ROS2_TERMINAL:
            clients.end(text, one)
        else:
            clients.goals.remove_old(now)
            clients.status = {goal.text: goal.status for goal in clients.goals.listed()}
            clients.goals.end_timeouts(now)
    clients.goals.abort_goals(set(), now)
    clients.goals.remove_old(now + LISTED_S + 0.1)
    assert all(status in ROS1_TERMINAL for _, status, _, _ in clients.results)
    assert sorted(text for text, _, _, _ in clients.results) == sorted(sent)
    assert not clients.goals.listed()
