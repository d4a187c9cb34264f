"""The action go_to."""

from typing import Any, Callable, Optional

import rospy

from bot_controller_demo.control.goal_controller import ARRIVED
from bot_controller_demo.control.progress_checker import GIVEN_UP
from bot_controller_demo.driving.goals import GoalRefused
from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToResult, Progress
from nodekit import Node, ServerGoalHandle


class GoToServer:
    """Serves ``go_to`` in the node's own callbacks; the newest goal replaces the one before.

    :param node: whose action it is
    :param accept: called with a goal's PoseStamped; raises GoalRefused
    :param stop: called where the robot is to stop
    """

    def __init__(self, node: Node, accept: Callable[[Any], None], stop: Callable[[], None]) -> None:
        self._accept = accept
        self._stop = stop
        self._goal: Optional[ServerGoalHandle] = None  # that the robot drives to
        node.create_action_server(
            "go_to", GoToAction, handle_accepted_callback=self._begin, newest_only=True
        )
        node.before_deactivate(self._forget)

    def _begin(self, goal: ServerGoalHandle) -> None:
        """Drive to a goal; the server has preempted the one before."""
        before, self._goal = self._goal, goal
        try:
            self._accept(goal.request.target_pose)
        except GoalRefused as refusal:
            rospy.logwarn("ignoring the goal: %s", refusal)
            self._goal = None
            if before is not None:  # otherwise another goal has the robot
                self._stop()
            goal.abort(text=str(refusal))

    def poll(self) -> None:
        """Stop the robot if its goal was cancelled."""
        goal = self._goal
        if goal is not None and goal.is_cancel_requested:
            self._forget()
            goal.canceled(text="cancelled: the robot has stopped")

    def _forget(self) -> None:
        """Stop the robot if the action drives it, so that it stands once it is active again."""
        if self._goal is not None:
            self._goal = None
            self._stop()

    def publish_progress(self, progress: Optional[Progress]) -> None:
        """Publish to the client how far the robot is.

        :param progress: on the way to the goal that was accepted last; None where it is not known
        """
        goal = self._goal
        if progress is None or goal is None:
            return
        goal.publish_feedback(GoToFeedback(progress))
        if progress.phase == ARRIVED:
            self._goal = None
            goal.succeed(GoToResult(progress), "arrived")
        elif progress.phase == GIVEN_UP:
            self._goal = None
            why = f"no progress: the robot has stopped {progress.distance:.2f} m from its goal"
            goal.abort(GoToResult(progress), why)

    def preempt(self) -> None:
        """Preempt the goal of a client: another one has replaced it."""
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.canceled(text="another goal was set")
