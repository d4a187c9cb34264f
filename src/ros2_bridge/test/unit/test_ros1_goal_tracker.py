"""The goals of a server of ROS 1, as clients of ROS 2 see them."""

from typing import Any, Dict, List, Optional, Sequence, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of
from ros2_bridge.actions.ros1_goal_tracker import (
    DONE,
    GOAL_IS_OVER,
    KEPT_S,
    REJECTED,
    RESULT_S,
    UNKNOWN_GOAL,
    TimedOutGoals,
    Goal,
    Ros1GoalTracker,
)
from ros2_bridge.actions.states import (
    ROS1_TERMINAL,
    ROS2_TRANSITIONS,
    Ros1Status,
    Ros2Status,
    nearest,
)

ONE, TWO = bytes([1]) * 16, bytes([2]) * 16
PATIENCE_S = 5.0
NOTHING = TimedOutGoals([], [])


class Clients:
    """Recorder of the calls to the clients of ROS 2."""

    def __init__(self) -> None:
        self.patience = PATIENCE_S
        self.goals = Ros1GoalTracker(lambda: self.patience, self._publish)
        self.accepted: Dict[bytes, List[bool]] = {}
        self.results: Dict[bytes, List[Tuple[Ros2Status, bytes]]] = {}
        self.cancelled: List[Tuple[int, List[bytes]]] = []
        self.status: Dict[bytes, Ros2Status] = {}
        self.stamps: Dict[bytes, int] = {}

    def _publish(self, goals: Sequence[Goal]) -> None:
        self.status, before = {}, self.status
        self.stamps = {goal.uuid: goal.stamp for goal in goals}
        for goal in goals:
            assert goal.status is not None
            self.status[goal.uuid] = goal.status
            first = before.get(goal.uuid, Ros2Status.ACCEPTED)
            assert nearest(ROS2_TRANSITIONS, first, [goal.status]) == goal.status, (
                first,
                goal.status,
            )

    def send(self, uuid: bytes, stamp: int = 1, now: float = 0.0) -> str:
        answers = self.accepted.setdefault(uuid, [])
        return self.goals.request_goal(uuid, stamp, now, answers.append)

    def ask(self, uuid: bytes) -> None:
        answers = self.results.setdefault(uuid, [])
        self.goals.request_result(uuid, lambda *answer: answers.append(answer))

    def cancel(self, uuid: bytes, until: int = 0, now: float = 0.0) -> Optional[str]:
        def hear(code: int, goals: Sequence[Goal]) -> None:
            self.cancelled.append((code, [goal.uuid for goal in goals]))

        return self.goals.request_cancel(uuid, until, now, hear)

    def list_goals(self, now: float = 0.0, **status: Ros1Status) -> None:
        uuids = {"one": ONE, "two": TWO}
        listed = [(text_of(uuids[name]), 1, one) for name, one in status.items()]
        self.goals.on_status(listed, now)

    def end(self, uuid: bytes, status: Ros1Status, result: bytes = b"", now: float = 0.0) -> None:
        self.goals.on_result(text_of(uuid), 1, status, result, now)


@pytest.fixture
def clients() -> Clients:
    return Clients()


def test_result_before_the_first_list_with_its_goal_counts(clients: Clients) -> None:
    clients.end(ONE, Ros1Status.SUCCEEDED, b"there")  # of a quick goal of a client of ROS 1
    clients.list_goals(one=Ros1Status.ACTIVE)  # delayed on a slower connection
    assert (clients.status, clients.stamps) == ({ONE: Ros2Status.SUCCEEDED}, {ONE: 1})
    clients.list_goals(one=Ros1Status.SUCCEEDED)
    assert clients.goals.end_timeouts(10.0 * PATIENCE_S) == NOTHING
    clients.ask(ONE)
    assert clients.results == {ONE: [(Ros2Status.SUCCEEDED, b"there")]}
    clients.end(TWO, Ros1Status.REJECTED)
    clients.end(NO_GOAL, Ros1Status.SUCCEEDED)
    assert list(clients.status) == [ONE]


def test_goal_goes_from_sending_to_its_result(clients: Clients) -> None:
    assert clients.send(ONE) == text_of(ONE)
    clients.list_goals(one=Ros1Status.PENDING)
    assert clients.accepted == {ONE: []} and not clients.status
    clients.list_goals(one=Ros1Status.ACTIVE)
    assert clients.accepted == {ONE: [True]} and clients.status == {ONE: Ros2Status.EXECUTING}
    clients.ask(ONE)
    clients.list_goals(one=Ros1Status.SUCCEEDED)
    assert clients.results == {ONE: []} and clients.status == {ONE: Ros2Status.EXECUTING}
    clients.end(ONE, Ros1Status.SUCCEEDED, b"far")
    assert clients.results == {ONE: [(Ros2Status.SUCCEEDED, b"far")]}
    assert clients.status == {ONE: Ros2Status.SUCCEEDED}
    clients.list_goals(one=Ros1Status.ACTIVE)  # older than the result
    clients.ask(ONE)
    assert clients.results[ONE] == 2 * [(Ros2Status.SUCCEEDED, b"far")]


def test_result_before_status_ends_goal(clients: Clients) -> None:
    clients.send(ONE)
    clients.end(ONE, Ros1Status.ABORTED, b"near")
    clients.ask(ONE)
    assert clients.accepted == {ONE: [True]}
    assert clients.results == {ONE: [(Ros2Status.ABORTED, b"near")]}


def test_rejected_goal_has_no_state(clients: Clients) -> None:
    clients.send(ONE)
    clients.send(TWO)
    clients.list_goals(one=Ros1Status.REJECTED)
    clients.end(TWO, Ros1Status.REJECTED)
    clients.list_goals(one=Ros1Status.REJECTED, two=Ros1Status.REJECTED)
    assert clients.accepted == {ONE: [False], TWO: [False]}
    assert not clients.status
    clients.ask(ONE)
    assert clients.results == {ONE: [(Ros2Status.UNKNOWN, b"")]}


def test_undecided_goal_is_accepted_in_time_and_may_still_be_rejected(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros1Status.PENDING)
    assert clients.goals.end_timeouts(PATIENCE_S) == NOTHING and clients.accepted == {ONE: []}
    assert clients.goals.end_timeouts(PATIENCE_S + 0.1) == NOTHING
    assert clients.accepted == {ONE: [True]} and clients.status == {ONE: Ros2Status.ACCEPTED}
    clients.end(ONE, Ros1Status.REJECTED)
    assert clients.status == {ONE: Ros2Status.ABORTED}


def test_goal_that_the_server_never_lists_is_given_up(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals()
    assert clients.goals.end_timeouts(PATIENCE_S + 0.1) == TimedOutGoals([text_of(ONE)], [])
    assert clients.accepted == {ONE: [False]}
    clients.list_goals(one=Ros1Status.RECALLING)
    clients.list_goals(one=Ros1Status.RECALLED)
    assert not clients.status


def test_goal_that_is_listed_no_longer_is_lost(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros1Status.ACTIVE)
    clients.ask(ONE)
    clients.list_goals()
    assert clients.results == {ONE: [(Ros2Status.ABORTED, b"")]}


@pytest.mark.parametrize("patience, longest", [(PATIENCE_S, PATIENCE_S), (0.1, RESULT_S)])
def test_missing_result_is_empty(clients: Clients, patience: float, longest: float) -> None:
    clients.patience = patience
    clients.send(ONE)
    clients.list_goals(one=Ros1Status.SUCCEEDED, now=1.0)
    clients.ask(ONE)
    clients.list_goals(one=Ros1Status.SUCCEEDED, now=1.5)  # the wait began before
    clients.list_goals(now=1.6)
    assert clients.goals.end_timeouts(1.0 + longest) == NOTHING
    assert clients.results == {ONE: []}
    assert clients.goals.end_timeouts(1.1 + longest) == TimedOutGoals([], [text_of(ONE)])
    assert clients.results == {ONE: [(Ros2Status.SUCCEEDED, b"")]}


def test_result_is_kept_for_a_time(clients: Clients) -> None:
    clients.send(ONE)
    clients.end(ONE, Ros1Status.SUCCEEDED, b"far", now=10.0)
    clients.goals.end_timeouts(10.0 + KEPT_S)
    assert clients.status
    clients.goals.end_timeouts(10.1 + KEPT_S)
    clients.ask(ONE)
    assert clients.results == {ONE: [(Ros2Status.UNKNOWN, b"")]} and not clients.status


def test_id_that_is_taken_is_rejected(clients: Clients) -> None:
    clients.send(ONE)
    assert clients.send(ONE) == "" and clients.accepted == {ONE: [False]}
    assert clients.send(NO_GOAL) == "" and clients.accepted[NO_GOAL] == [False]


def test_ros1_goals_are_tracked(clients: Clients) -> None:
    clients.goals.on_status([("/node-1-7.5", 7, Ros1Status.ACTIVE)], 0.0)
    uuid = bytes_of("/node-1-7.5")
    assert (clients.status, clients.stamps) == ({uuid: Ros2Status.EXECUTING}, {uuid: 7})
    assert clients.cancel(uuid) == "/node-1-7.5"
    clients.ask(uuid)
    clients.goals.on_result("/node-1-7.5", 7, Ros1Status.PREEMPTED, b"far", 0.0)
    assert clients.results == {uuid: [(Ros2Status.CANCELED, b"far")]}
    assert clients.cancelled == [(DONE, [uuid])]


@pytest.mark.parametrize(
    "status, seen",
    [
        (Ros1Status.PENDING, Ros2Status.ACCEPTED),
        (Ros1Status.ACTIVE, Ros2Status.EXECUTING),
        (Ros1Status.PREEMPTING, Ros2Status.CANCELING),
        (Ros1Status.RECALLING, None),
        (Ros1Status.ABORTED, None),
    ],
)
def test_ros1_goal_is_tracked_if_it_may_still_succeed(
    clients: Clients, status: Ros1Status, seen: Optional[Ros2Status]
) -> None:
    clients.goals.on_status([("/node-1-7.5", 7, status)], 0.0)  # at the start of the bridge
    assert list(clients.status.values()) == ([seen] if seen else [])


def test_cancellation_is_answered_when_all_goals_react(clients: Clients) -> None:
    clients.send(ONE, 1)
    clients.send(TWO, 2)
    clients.list_goals(one=Ros1Status.ACTIVE, two=Ros1Status.ACTIVE)
    assert clients.cancel(NO_GOAL, 1) == ""
    assert clients.cancel(NO_GOAL) == ""
    assert clients.cancelled == []
    clients.list_goals(one=Ros1Status.PREEMPTING, two=Ros1Status.ACTIVE)
    assert clients.cancelled == [(DONE, [ONE])]
    clients.end(TWO, Ros1Status.SUCCEEDED)
    assert clients.cancelled[1:] == [(DONE, [ONE])]


def test_cancellation_that_nobody_follows_is_rejected(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros1Status.ACTIVE)
    assert clients.cancel(ONE, now=1.0) == text_of(ONE)
    clients.goals.end_timeouts(1.0 + PATIENCE_S)
    assert clients.cancelled == []
    clients.goals.end_timeouts(1.1 + PATIENCE_S)
    assert clients.cancelled == [(REJECTED, [])]


def test_cancellation_of_unknown_goal_is_not_sent(clients: Clients) -> None:
    assert clients.cancel(ONE) is None
    clients.send(ONE)
    assert clients.cancel(ONE) is None  # it has not been accepted
    clients.end(ONE, Ros1Status.SUCCEEDED)
    assert clients.cancel(ONE) is None
    assert clients.cancelled == [(UNKNOWN_GOAL, [])] * 2 + [(GOAL_IS_OVER, [])]
    assert clients.cancel(TWO, 5) == text_of(TWO)  # those until then, and this one if it comes
    assert clients.cancelled[3:] == [(DONE, [])]


def test_server_that_goes_takes_all_goals_with_it(clients: Clients) -> None:
    clients.send(ONE)
    clients.list_goals(one=Ros1Status.ACTIVE)
    clients.ask(ONE)
    clients.cancel(ONE)
    clients.send(TWO)
    clients.goals.abort_all(3.0)
    assert clients.results == {ONE: [(Ros2Status.ABORTED, b"")]}
    assert clients.accepted == {ONE: [True], TWO: [False]}
    assert clients.cancelled == [(REJECTED, [])]


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["send", "ask", "cancel", "status", "end", "wait"]),
        st.sampled_from([ONE, TWO]),
        st.lists(st.sampled_from(Ros1Status), min_size=2, max_size=2),
        st.floats(0.0, 2.0),
    ),
    max_size=30,
)


@given(EVENTS)
def test_each_request_has_one_answer(events: List[Any]) -> None:
    clients, now = Clients(), 0.0
    sent: List[bytes] = []
    asked = cancelled = 0
    for what, uuid, (one, two), pause in events:
        now += pause
        if what == "send" and uuid not in sent:
            sent.append(uuid)
            clients.send(uuid, int(now), now)
        elif what == "ask":
            asked += 1
            clients.ask(uuid)
        elif what == "cancel":
            cancelled += 1
            clients.cancel(uuid, 0, now)
        elif what == "status":
            clients.list_goals(now, one=one, two=two)
        elif what == "end" and one in ROS1_TERMINAL:
            clients.end(uuid, one, b"far", now)
        else:
            clients.goals.end_timeouts(now)
    clients.goals.abort_all(now)
    clients.goals.end_timeouts(now + PATIENCE_S + 0.1)
    assert all(len(answers) == 1 for answers in clients.accepted.values())
    assert sum(map(len, clients.results.values())) == asked
    assert len(clients.cancelled) == cancelled
    for uuid, answers in clients.results.items():
        known = {status for status, _ in answers if status != Ros2Status.UNKNOWN}
        assert len(known) <= 1 and not known.intersection(ROS2_TRANSITIONS)
