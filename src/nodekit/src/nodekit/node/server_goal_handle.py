"""ServerGoalHandle: handle of an accepted goal for the callbacks of its server."""

from typing import Any, Optional, Tuple

from nodekit.actions.goal_list import Goal
from nodekit.actions.goal_states import RUNNING, GoalEvent, GoalState


class ServerGoalHandle:
    """Handle through which the callbacks of a server follow and end a goal. Thread-safe.

    :param server: the :class:`.ActionServer`
    :param goal: its entry in the server's list
    :param request: the goal's message

    :ivar request: the goal's message
    :ivar outcome: how the running execute callback has ended it, until it returns the result
    :ivar is_ended_by_server: whether the server, not a callback, has ended it
    :ivar executing_thread: id of the thread of its execute callback; 0 without one, -1 before and
        after the call
    """

    __slots__ = ("request", "outcome", "is_ended_by_server", "executing_thread", "_server", "goal")

    def __init__(self, server: Any, goal: Goal, request: Any) -> None:
        self.request = request
        self.goal = goal
        self.outcome: Optional[Tuple[GoalEvent, str]] = None
        self.is_ended_by_server = False
        self.executing_thread = 0
        self._server = server

    @property
    def goal_id(self) -> str:
        """Id of the goal."""
        return self.goal.id

    @property
    def status(self) -> GoalState:
        """State of the goal, one of those in actionlib_msgs/GoalStatus."""
        return self.goal.state

    @property
    def is_active(self) -> bool:
        """Whether the goal is accepted and has not ended."""
        return self.goal.state in RUNNING

    @property
    def is_cancel_requested(self) -> bool:
        """Whether the goal is to end: at a client's request, for a newer goal, or with its node."""
        return self.goal.state is not GoalState.ACTIVE

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the goal's client.

        No effect if the server has ended the goal meanwhile.

        :param feedback: of the action's feedback class
        :raises TypeError: if it is of another class, or the value of a field does not fit its type
        :raises GoalError: if a callback has ended the goal
        """
        self._server.publish_feedback(self, feedback)

    def execute(self) -> None:
        """Call the server's execute callback for this goal, in its own thread.

        Without a ``handle_accepted_callback``, the server does so itself.

        :raises GoalError: if the server has no execute callback, or it is called already
        """
        self._server.execute(self)

    def succeed(self, result: Any = None, text: str = "") -> None:
        """End the goal as succeeded.

        Without a result, the goal ends with the result of the running execute callback. No effect
        if the server has ended the goal meanwhile.

        :param result: of the action's result class
        :param text: text for the client
        :raises TypeError: if the result is of another class, or the value of a field does not fit
        :raises GoalError: if a callback has ended the goal before
        """
        self._server.end(self, GoalEvent.SUCCEED, result, text)

    def abort(self, result: Any = None, text: str = "") -> None:
        """End the goal as aborted; see :meth:`succeed`."""
        self._server.end(self, GoalEvent.ABORT, result, text)

    def canceled(self, result: Any = None, text: str = "") -> None:
        """End the goal as cancelled, PREEMPTED in actionlib; see :meth:`succeed`."""
        self._server.end(self, GoalEvent.CANCEL, result, text)
