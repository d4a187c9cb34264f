"""Tracker of a ROS 2 server's goals, with the states that its ROS 1 clients see."""

from typing import Callable, Collection, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of
from ros2_bridge.actions.states import (
    ROS2_TERMINAL,
    RESULT_S,
    ROS1_TRANSITIONS,
    ROS2_TRANSITIONS,
    TO_ROS1,
    Ros1Status,
    Ros2Status,
    nearest,
    matches_cancel_request,
)

#: Ended goals are listed, and cancellations that arrive before their goal kept, for this time [s],
#: as in actionlib's server.
LISTED_S = 5.0
RECALLED = "cancelled before it started"
REJECTED = "the server in ROS 2 has rejected it"
NO_ANSWER = "the server in ROS 2 does not answer"
NO_RESULT = "the server in ROS 2 does not send its result"
NO_END = "the server in ROS 2 does not send its final status"
GONE = "the server in ROS 2, or the bridge to it, has ended"


class Goal:
    """A goal.

    :param text: its id in ROS 1
    :param uuid: its id in ROS 2
    :param stamp: its start time [ns]
    :param now: arrival time on the timeout clock [s]
    :param is_own: whether a ROS 1 client sent it

    :ivar why: text of its status
    """

    def __init__(self, text: str, uuid: bytes, stamp: int, now: float, is_own: bool) -> None:
        self.text, self.uuid, self.stamp, self.is_own = text, uuid, stamp, is_own
        self.since = now
        self.status, self.why = Ros1Status.PENDING, ""
        #: Whether the server has accepted it, and whether to cancel it once accepted.
        self.is_accepted, self.is_to_be_cancelled = not is_own, False
        #: Whether the server has listed it.
        self.is_listed = False
        #: Ids of the publisher that listed it, or of those that existed when it arrived: if they
        #: are gone, so is its server, even if another server of that name has started.
        self.senders: Set[bytes] = set()
        #: Final status according to the server's list, and when that arrived.
        self.awaiting_result: Optional[Tuple[Ros2Status, float]] = None
        #: Whether only a cancellation of it has arrived, not the goal itself.
        self.is_awaited = False
        self.ended: Optional[float] = None

    @property
    def is_under_way(self) -> bool:
        """Whether it has arrived, and has not ended."""
        return self.status in ROS1_TRANSITIONS and not self.is_awaited


class TimedOutGoals(NamedTuple):
    """Goals whose timeout has elapsed.

    :param accepted: listed by the server, which has not answered: treat them as accepted
    :param without_result: ended according to the list, but the result is missing
    """

    accepted: Sequence[Goal]
    without_result: Sequence[Goal]


class Ros2GoalTracker:
    """Tracker of goals. Time is an argument; not thread-safe.

    :param patience: returns the timeout for an answer, and for a result [s]
    :param publish_result: called with an ended ROS 1 goal and its ROS 2 result, None if missing
    :param publish_status: called with the goals after a change
    """

    def __init__(
        self,
        patience: Callable[[], float],
        publish_result: Callable[[Goal, Optional[bytes]], None],
        publish_status: Callable[[Sequence[Goal]], None],
    ) -> None:
        self._patience = patience
        self._publish_result, self._publish_status = publish_result, publish_status
        self._goals: Dict[bytes, Goal] = {}
        self._cancelled_until = 0

    def listed(self) -> List[Goal]:
        """Return the goals for the status list."""
        return list(self._goals.values())

    def request_goal(self, text: str, stamp: int, now: float) -> Optional[bytes]:
        """Add a goal from ROS 1.

        :param stamp: its start time [ns]
        :returns: the id to send it with; None if it is not to be sent
        """
        uuid = bytes_of(text)
        goal = self._goals.get(uuid)
        if goal is not None and not goal.is_awaited:
            return None
        is_cancelled = goal is not None or 0 < stamp <= self._cancelled_until
        goal = self._goals[uuid] = Goal(text, uuid, stamp, now, True)
        if is_cancelled:
            self._end(goal, [Ros1Status.RECALLED], now, RECALLED)
            return None
        self._publish()
        return uuid

    def on_goal_response(
        self, uuid: bytes, is_accepted: bool, now: float, why: str = REJECTED
    ) -> bool:
        """Handle the server's answer to a goal.

        :param why: reason if it is not accepted
        :returns: whether to cancel the goal now
        """
        goal = self._goals.get(uuid)
        if goal is None or not goal.is_under_way:
            return is_accepted  # for its client it has already ended
        goal.is_accepted = is_accepted
        if not is_accepted:
            # The server may have listed it before.
            self._end(goal, [Ros1Status.REJECTED, Ros1Status.ABORTED], now, why)
        return is_accepted and goal.is_to_be_cancelled

    def on_status(
        self, listed: Sequence[Tuple[bytes, int, Ros2Status]], sender: bytes, now: float
    ) -> List[bytes]:
        """Handle the server's status list.

        :param listed: id, stamp [ns], and status of each goal
        :param sender: id of the publisher
        :returns: the ids of goals that were cancelled before they were listed
        """
        cancelled = []
        for uuid, stamp, status in listed:
            goal = self._goals.get(uuid)
            if goal is None and status in ROS2_TRANSITIONS:
                goal = self._goals[uuid] = Goal(text_of(uuid), uuid, stamp, now, False)
            elif goal is not None and goal.is_awaited and status in ROS2_TRANSITIONS:
                goal = self._goals[uuid] = Goal(goal.text, uuid, stamp, now, False)
                goal.status = Ros1Status.RECALLING
                cancelled.append(uuid)
            if goal is None or not goal.is_under_way:
                continue
            goal.senders, goal.is_listed = {sender}, True
            if status in ROS2_TRANSITIONS:
                goal.status = nearest(ROS1_TRANSITIONS, goal.status, TO_ROS1[status])
            elif status in ROS2_TERMINAL and not goal.is_own:
                self._end(goal, TO_ROS1[status], now)
            elif (
                status in ROS2_TERMINAL and goal.awaiting_result is None
            ):  # own goals await a result
                goal.awaiting_result = (status, now)
        self._publish()
        return cancelled

    def on_result(
        self, uuid: bytes, status: Ros2Status, result: Optional[bytes], now: float
    ) -> None:
        """End a ROS 1 goal.

        :param result: passed on
        """
        goal = self._goals.get(uuid)
        if goal is not None and goal.is_under_way:
            is_end = status in ROS2_TERMINAL
            wanted = TO_ROS1[status if is_end else Ros2Status.UNKNOWN]
            self._end(goal, wanted, now, "" if is_end else NO_END, result)

    def request_cancel(self, wanted: str, until: int, now: float) -> List[bytes]:
        """Cancel goals: see :func:`.matches_cancel_request`; a pending goal once it is accepted.

        :returns: the ids of the goals to cancel now; NO_GOAL for all
        """
        self._cancelled_until = max(self._cancelled_until, until)
        uuid = bytes_of(wanted)
        if wanted and uuid not in self._goals:  # the request has overtaken its goal
            early = self._goals[uuid] = Goal(wanted, uuid, until, now, False)
            early.status, early.is_awaited, early.ended = Ros1Status.RECALLING, True, now
            self._publish()
        meant = []
        for goal in self._goals.values():
            # Also by its ROS 2 id: a restarted bridge does not know the string of a ROS 1 goal.
            is_it = goal.uuid == uuid or matches_cancel_request(
                goal.text, goal.stamp, wanted, until
            )
            if goal.is_under_way and is_it:
                goal.is_to_be_cancelled = True
                if goal.is_accepted:
                    meant.append(goal.uuid)
        return meant if wanted or until else [NO_GOAL]

    def abort_goals(self, senders: Collection[bytes], now: float) -> None:
        """End the goals whose server is gone.

        :param senders: ids of the existing publishers of the list
        :param now: when these were looked up [s]; later goals are not affected
        """
        for goal in self.listed():
            if goal.since > now:
                continue
            if not goal.senders:
                goal.senders = set(senders)
            if goal.is_under_way and not goal.senders.intersection(senders):
                self._end(goal, TO_ROS1[Ros2Status.ABORTED], now, GONE)

    def end_timeouts(self, now: float) -> TimedOutGoals:
        """End the goals that the server has not answered in time."""
        accepted, without_result, patience = [], [], self._patience()
        for goal in self.listed():
            if not goal.is_under_way:
                continue
            if goal.awaiting_result is not None:
                status, since = goal.awaiting_result
                if now > since + max(RESULT_S, patience):
                    without_result.append(goal)
                    self._end(goal, TO_ROS1[status], now, NO_RESULT)
            elif not goal.is_accepted and now > goal.since + patience:
                if goal.is_listed:
                    goal.is_accepted = True
                    accepted.append(goal)
                else:
                    self._end(goal, [Ros1Status.REJECTED], now, NO_ANSWER)
        return TimedOutGoals(accepted, without_result)

    def is_any_under_way(self) -> bool:
        """Return whether any goal is active."""
        return any(goal.is_under_way for goal in self._goals.values())

    def under_way(self, uuid: bytes) -> Optional[Goal]:
        """Return an active goal, or None."""
        goal = self._goals.get(uuid)
        return goal if goal is not None and goal.is_under_way else None

    def remove_old(self, now: float) -> None:
        """Remove goals that ended long ago."""
        for goal in self.listed():
            if goal.ended is not None and now > goal.ended + LISTED_S:
                del self._goals[goal.uuid]

    def _end(
        self,
        goal: Goal,
        wanted: Collection[Ros1Status],
        now: float,
        why: str = "",
        result: Optional[bytes] = None,
    ) -> None:
        goal.status, goal.why = nearest(ROS1_TRANSITIONS, goal.status, wanted), why
        goal.ended = now
        if goal.is_own:
            self._publish_result(goal, result)
        self._publish()

    def _publish(self) -> None:
        self._publish_status(self.listed())
