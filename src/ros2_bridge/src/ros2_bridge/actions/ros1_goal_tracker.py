"""Tracker of a ROS 1 server's goals, with the states that its ROS 2 clients see."""

from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of
from ros2_bridge.actions.states import (
    ROS2_TERMINAL,
    RESULT_S,
    ROS2_TRANSITIONS,
    TO_ROS2,
    Ros1Status,
    Ros2Status,
    nearest,
    matches_cancel_request,
)

#: Results are kept for this time [s]: rclpy's ``result_timeout``.
KEPT_S = 900.0
#: Return codes of action_msgs/CancelGoal.
DONE, REJECTED, UNKNOWN_GOAL, GOAL_IS_OVER = range(4)
#: States in which a goal unknown to ROS 2 is tracked.
_OPEN = (Ros1Status.PENDING, Ros1Status.ACTIVE, Ros1Status.PREEMPTING)

AnswerGoal = Callable[[bool], None]
AnswerResult = Callable[[Ros2Status, bytes], None]


class Goal:
    """A goal.

    :param text: its id in ROS 1
    :param stamp: its start time in ROS 1 [ns]
    :param now: creation time on the timeout clock [s]
    :param answer: informs the client whether it is accepted; None for a goal from ROS 1

    :ivar uuid: its id in ROS 2
    :ivar status: None until it is accepted
    """

    def __init__(self, text: str, stamp: int, now: float, answer: Optional[AnswerGoal]) -> None:
        self.text, self.uuid, self.stamp, self.answer = text, bytes_of(text), stamp, answer
        self.status: Optional[Ros2Status] = None
        self.since = now
        #: Whether the server's status has listed it; once listed, a goal that is missing is lost.
        self.is_listed = False
        self.awaiting_result: Optional[Tuple[Ros1Status, float]] = None
        self.result = b""
        self.waiting: List[AnswerResult] = []

    @property
    def is_under_way(self) -> bool:
        """Whether it was accepted, and has not ended."""
        return self.status in ROS2_TRANSITIONS

    @property
    def is_over(self) -> bool:
        """Whether it has a result."""
        return self.status in ROS2_TERMINAL


AnswerCancel = Callable[[int, Sequence[Goal]], None]


class _Cancellation(NamedTuple):
    goals: Sequence[Goal]
    answer: AnswerCancel
    since: float


class TimedOutGoals(NamedTuple):
    """Ids of goals whose timeout has elapsed.

    :param unheard: never listed by the server, which has to cancel them, as it may still start them
    :param without_result: ended according to the server, but the result is missing
    """

    unheard: Sequence[str]
    without_result: Sequence[str]


class Ros1GoalTracker:
    """Tracker of goals. Time is an argument; not thread-safe.

    :param patience: returns the timeout for the server's reaction to a new goal or a cancellation,
        and for a result [s]
    :param publish_status: called with the goals known to ROS 2 whenever one has changed
    """

    def __init__(
        self, patience: Callable[[], float], publish_status: Callable[[Sequence[Goal]], None]
    ) -> None:
        self._patience, self._publish_status = patience, publish_status
        self._goals: Dict[str, Goal] = {}
        self._cancellations: List[_Cancellation] = []
        self._is_changed = False

    def request_goal(self, uuid: bytes, stamp: int, now: float, answer: AnswerGoal) -> str:
        """Add a goal from ROS 2.

        :param stamp: start time for the server [ns]
        :param answer: called with whether it is accepted
        :returns: the id to send it with; empty if a goal with this id exists
        """
        text = text_of(uuid)
        if not text or text in self._goals:
            answer(False)
            return ""
        self._goals[text] = Goal(text, stamp, now, answer)
        return text

    def request_result(self, uuid: bytes, answer: AnswerResult) -> None:
        """Answer with the result once it exists; with UNKNOWN if there is no such goal."""
        goal = self._find(uuid)
        if goal is None or goal.status is None:
            answer(Ros2Status.UNKNOWN, b"")
        elif goal.is_over:
            answer(goal.status, goal.result)
        else:
            goal.waiting.append(answer)

    def request_cancel(
        self, uuid: bytes, until: int, now: float, answer: AnswerCancel
    ) -> Optional[str]:
        """Cancel goals: see :func:`.matches_cancel_request`.

        :param answer: called with a CancelGoal code and the goals being cancelled, once the server
            has confirmed each
        :returns: the id for the cancel message; None if none is to be sent
        """
        goal = self._find(uuid)
        if uuid != NO_GOAL and not until and (goal is None or not goal.is_under_way):
            is_over = goal is not None and goal.is_over
            answer(GOAL_IS_OVER if is_over else UNKNOWN_GOAL, ())
            return None
        wanted = goal.text if goal is not None else text_of(uuid)
        meant = [
            one
            for one in self._goals.values()
            if one.is_under_way and matches_cancel_request(one.text, one.stamp, wanted, until)
        ]
        self._cancellations.append(_Cancellation(meant, answer, now))
        self._answer_cancellations(now)
        return wanted

    def _find(self, uuid: bytes) -> Optional[Goal]:
        found = self._goals.get(text_of(uuid))
        if found is None:  # a goal from ROS 1
            found = next((one for one in self._goals.values() if one.uuid == uuid), None)
        return found

    def on_status(
        self, listed: Sequence[Tuple[str, int, Optional[Ros1Status]]], now: float
    ) -> None:
        """Handle the server's status list.

        :param listed: id, stamp [ns], and status of each goal; None for an unknown status, which
            ROS 1's own clients ignore
        """
        for text, stamp, status in listed:
            if text not in self._goals and status in _OPEN:
                self._goals[text] = Goal(text, stamp, now, None)
            goal = self._goals.get(text)
            if goal is None:
                continue
            goal.is_listed = True
            if status is None:
                continue
            if TO_ROS2[status] not in ROS2_TERMINAL or (goal.status, status) == (
                None,
                Ros1Status.REJECTED,
            ):
                self._move(goal, status, now)
                continue
            if goal.status is None:
                self._accept(goal)
            if not goal.is_over and goal.awaiting_result is None:
                goal.awaiting_result = (status, now)
        texts = {text for text, _, _ in listed}
        for goal in list(self._goals.values()):
            is_waiting = goal.awaiting_result is not None
            if goal.is_listed and goal.text not in texts and not (goal.is_over or is_waiting):
                self._move(goal, Ros1Status.LOST, now)
        self._report(now)

    def on_result(
        self, text: str, stamp: int, status: Ros1Status, result: bytes, now: float
    ) -> None:
        """End a goal, even a ROS 1 goal whose result arrives before a status list contains it.

        The list uses another connection; a late one would make the goal look active.

        :param stamp: start time of the goal [ns]
        :param status: final status
        :param result: its result, serialized in ROS 1
        """
        goal = self._goals.get(text)
        if goal is None and not text:
            return  # no goal id
        if goal is None:
            goal = self._goals[text] = Goal(text, stamp, now, None)
        self._move(goal, status, now, result)
        self._report(now)

    def abort_all(self, now: float) -> None:
        """Abort all goals, because the server is gone."""
        for goal in list(self._goals.values()):
            self._move(goal, Ros1Status.LOST, now)
        self._report(now)

    def end_timeouts(self, now: float) -> TimedOutGoals:
        """End the goals and requests whose timeout has elapsed."""
        unheard, without_result, patience = [], [], self._patience()
        for goal in list(self._goals.values()):
            if goal.answer is not None and now > goal.since + patience:
                if goal.is_listed:  # the server has queued it
                    self._accept(goal)
                else:
                    unheard.append(goal.text)
                    self._move(goal, Ros1Status.LOST, now)
            elif goal.awaiting_result is not None:
                status, since = goal.awaiting_result
                if now > since + max(RESULT_S, patience):
                    without_result.append(goal.text)
                    self._move(goal, status, now)
            elif goal.is_over and now > goal.since + KEPT_S:
                del self._goals[goal.text]
                self._is_changed = True
        self._report(now)
        return TimedOutGoals(unheard, without_result)

    def publish_all(self) -> None:
        """Publish the goals known to ROS 2."""
        self._publish_status([one for one in self._goals.values() if one.status is not None])

    def _move(self, goal: Goal, status: Ros1Status, now: float, result: bytes = b"") -> None:
        """Move a goal to the state reported by the server, which may be outdated."""
        if goal.is_over:
            return
        if goal.status is None:
            if status in (Ros1Status.REJECTED, Ros1Status.LOST):
                del self._goals[goal.text]
                self._answer_goal(goal, False)
                return
            if goal.answer is not None and status == Ros1Status.PENDING:
                return  # not accepted yet
            self._accept(goal)
        before = goal.status or Ros2Status.ACCEPTED
        goal.status = nearest(ROS2_TRANSITIONS, before, [TO_ROS2[status]])
        if goal.is_over:
            goal.result, goal.since, goal.awaiting_result = result, now, None
            waiting, goal.waiting = goal.waiting, []
            for answer in waiting:
                answer(goal.status, result)
        self._is_changed = self._is_changed or goal.status != before

    def _accept(self, goal: Goal) -> None:
        goal.status, self._is_changed = Ros2Status.ACCEPTED, True
        self._answer_goal(goal, True)

    def _answer_goal(self, goal: Goal, is_accepted: bool) -> None:
        answer, goal.answer = goal.answer, None
        if answer is not None:
            answer(is_accepted)

    def _report(self, now: float) -> None:
        """Publish changes, and then answer requests that waited for them."""
        if self._is_changed:
            self._is_changed = False
            self.publish_all()
        self._answer_cancellations(now)

    def _answer_cancellations(self, now: float) -> None:
        """Answer the cancel requests whose goals have all reacted or timed out."""
        kept = []
        for one in self._cancellations:
            follow = [
                g for g in one.goals if g.status in (Ros2Status.CANCELING, Ros2Status.CANCELED)
            ]
            if now <= one.since + self._patience() and any(
                goal.is_under_way and goal.status != Ros2Status.CANCELING for goal in one.goals
            ):
                kept.append(one)
            else:
                one.answer(DONE if follow or not one.goals else REJECTED, follow)
        self._cancellations = kept
