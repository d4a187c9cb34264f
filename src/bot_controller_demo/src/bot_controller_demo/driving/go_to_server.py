"""Server of the action go_to."""

from typing import Any, Callable, Optional

import rospy

from bot_controller_demo.control.goal_controller import ARRIVED
from bot_controller_demo.control.progress_checker import GIVEN_UP
from bot_controller_demo.driving.goals import GoalRefused
from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToResult, Progress
from nodekit import Node, ServerGoalHandle


class GoToServer:
    """Server of ``go_to`` in the node's own callbacks; a new goal replaces the current one.

    :param node: owner of the action
    :param accept: called with a goal's PoseStamped; raises GoalRefused
    :param stop: called to stop the robot
    """

    def __init__(self, node: Node, accept: Callable[[Any], None], stop: Callable[[], None]) -> None:
        self._accept = accept
        self._stop = stop
        self._goal: Optional[ServerGoalHandle] = None  # current goal of the action
        node.create_action_server(
            "go_to", GoToAction, handle_accepted_callback=self._begin, newest_only=True
        )
        node.before_deactivate(self._forget)

    def _begin(self, goal: ServerGoalHandle) -> None:
        """Drive to a goal; the server has preempted the previous one."""
        before, self._goal = self._goal, goal
        try:
            self._accept(goal.request.target_pose)
        except GoalRefused as error:
            rospy.logwarn("ignoring the goal: %s", error)
            self._goal = None
            if before is not None:  # otherwise the robot drives to a goal of another source
                self._stop()
            goal.abort(text=str(error))

    def poll(self) -> None:
        """Stop the robot if its goal was cancelled."""
        goal = self._goal
        if goal is not None and goal.is_cancel_requested:
            self._forget()
            goal.canceled(text="cancelled: the robot has stopped")

    def _forget(self) -> None:
        """Stop the robot if the action drives it, so that it rests after an activation."""
        if self._goal is not None:
            self._goal = None
            self._stop()

    def publish_progress(self, progress: Optional[Progress]) -> None:
        """Publish the progress to the client.

        :param progress: towards the accepted goal; None if unknown
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
        """Preempt a client's goal, because another goal has replaced it."""
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.canceled(text="another goal was set")
