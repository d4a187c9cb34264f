"""GoalList: a server's list of goals, which selects the goals to cancel."""

from typing import Dict, Iterator, List, NamedTuple, Optional

from nodekit.actions.goal_states import CANCELING, ENDED, GoalEvent, GoalState, state_after

#: How long a goal that has ended is listed, as by actionlib [s].
LISTED_S = 5.0


class Goal:
    """Goal of a server.

    :param id: its id
    :param stamp: ROS time at which its client sent it [ns]

    :ivar state: its state
    :ivar text: the server's comment on its state
    :ivar ended_at: monotonic time at which it ended, or was cancelled before it arrived [s]
    """

    __slots__ = ("id", "stamp", "state", "text", "ended_at")

    def __init__(self, id: str, stamp: int) -> None:
        self.id, self.stamp = id, stamp
        self.state, self.text = GoalState.PENDING, ""
        self.ended_at: Optional[float] = None

    @property
    def has_ended(self) -> bool:
        """Whether the goal has ended."""
        return self.state in ENDED


class AddedGoal(NamedTuple):
    """Result of adding a goal to the list.

    :param goal: the listed goal
    :param is_new: whether the server has to decide about it
    :param is_recalled: whether it has just been recalled: cancelled before it arrived
    """

    goal: Goal
    is_new: bool
    is_recalled: bool


class GoalList:
    """Goals of a server, in order of arrival."""

    def __init__(self) -> None:
        self._goals: Dict[str, Goal] = {}
        self._cancelled_until = 0  # ROS time [ns]

    def __iter__(self) -> Iterator[Goal]:
        return iter(list(self._goals.values()))

    def add(self, id: str, stamp: int, ros_time: int, now: float) -> AddedGoal:
        """Add a goal on arrival.

        :param id: its id
        :param stamp: ROS time at which it was sent; 0 if unknown [ns]
        :param ros_time: ROS time now [ns]
        :param now: monotonic time [s]
        """
        known = self._goals.get(id)
        if known is not None:
            is_recalled = known.state is GoalState.RECALLING and known.ended_at is not None
            if is_recalled:
                self.apply(known, GoalEvent.CANCEL, "cancelled before it arrived", now)
            return AddedGoal(known, False, is_recalled)
        goal = self._goals[id] = Goal(id, stamp or ros_time)
        if ros_time < self._cancelled_until:  # the clock was set back
            self._cancelled_until = 0
        is_recalled = 0 < stamp <= self._cancelled_until
        if is_recalled:
            self.apply(goal, GoalEvent.CANCEL, "cancelled before it arrived", now)
        return AddedGoal(goal, not is_recalled, is_recalled)

    def cancel(self, id: str, stamp: int, ros_time: int, now: float) -> List[Goal]:
        """Return the goals that a cancellation selects.

        That is the goal with the id, and all that were sent until the stamp; all goals if both are
        unset. A goal that arrives later is cancelled too if it has the id or was sent until then.

        :param id: id of a goal, or empty
        :param stamp: ROS time, or 0 [ns]; one ahead of now means now
        :param ros_time: ROS time now [ns]
        :param now: monotonic time [s]
        :returns: running goals that were not cancelled before
        """
        if id and id not in self._goals:
            early = self._goals[id] = Goal(id, stamp)
            early.state, early.ended_at = GoalState.RECALLING, now
        until = min(stamp, ros_time)
        self._cancelled_until = max(self._cancelled_until, until)
        is_for_all = not id and not stamp
        return [
            goal
            for goal in self
            if (is_for_all or goal.id == id or goal.stamp <= stamp != 0)
            and not goal.has_ended
            and goal.state not in CANCELING
        ]

    def apply(self, goal: Goal, event: GoalEvent, text: str, now: float) -> bool:
        """Change a goal's state by an event.

        :param goal: a listed goal
        :param event: the event
        :param text: the server's comment on the new state
        :param now: monotonic time [s]
        :returns: whether that is allowed in its state
        """
        state = state_after(goal.state, event)
        if state is None:
            return False
        goal.state, goal.text = state, text
        if goal.has_ended:
            goal.ended_at = now
        return True

    def drop_ended(self, now: float) -> None:
        """Drop the goals that have been listed long enough after their end.

        :param now: monotonic time [s]
        """
        for goal in self:
            if goal.ended_at is not None and now - goal.ended_at > LISTED_S:
                del self._goals[goal.id]
