"""The action go_to, where Debian's python3-actionlib is installed."""

from typing import Any, Callable, Optional

import rospy

from bot_controller_demo.driving.goals import GoalRefused
from bot_controller_demo.laws.pursuit import ARRIVED
from bot_controller_demo.laws.standstill import GIVEN_UP
from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToResult, Progress
from nodekit import Node

try:
    import actionlib
except ImportError:
    actionlib = None


class GoToServer:
    """Serves ``go_to`` by polling it in each control period, so in the node's own callbacks.

    :param node: whose action it is
    :param accept: called with a goal's PoseStamped; raises GoalRefused
    :param stop: called where the robot is to stop
    """

    def __init__(self, node: Node, accept: Callable[[Any], None], stop: Callable[[], None]) -> None:
        self._accept = accept
        self._stop = stop
        self._server: Any = None
        self._is_new = True
        if actionlib is None:
            rospy.logwarn("no action go_to: python3-actionlib is not installed; the rest works")
            return
        self._server = actionlib.SimpleActionServer(
            node.resolve("go_to"), GoToAction, auto_start=False
        )
        node.own(self)
        node.before_deactivate(self.abort)

    def poll(self) -> None:
        """Handle what clients have requested since the last call."""
        server = self._server
        if server is None:
            return
        if self._is_new:
            self._is_new = False
            server.start()
        if server.is_new_goal_available():
            is_driving = server.is_active()
            goal = server.accept_new_goal()  # the one before is preempted by this
            try:
                self._accept(goal.target_pose)
            except GoalRefused as refusal:
                rospy.logwarn("ignoring the goal: %s", refusal)
                if is_driving:  # otherwise another goal has the robot
                    self._stop()
                server.set_aborted(GoToResult(), str(refusal))
        elif server.is_active() and server.is_preempt_requested():
            self._stop()
            server.set_preempted(GoToResult(), "cancelled: the robot has stopped")

    def abort(self) -> None:
        """Abort the goal: a node that stops being active may never be so again."""
        if self._server.is_active():
            self._stop()
            self._server.set_aborted(GoToResult(), "the controller is not active any more")

    def close(self) -> None:
        """Stop serving: a managed node that is configured again has another server."""
        if not self._is_new:
            self._server.action_server.stop()

    def publish_progress(self, progress: Optional[Progress]) -> None:
        """Publish to the client how far the robot is.

        :param progress: on the way to the goal that was accepted last; None where it is not known
        """
        if progress is None or self._server is None or not self._server.is_active():
            return
        self._server.publish_feedback(GoToFeedback(progress))
        if progress.phase == ARRIVED:
            self._server.set_succeeded(GoToResult(progress), "arrived")
        elif progress.phase == GIVEN_UP:
            why = f"no progress: the robot has stopped {progress.distance:.2f} m from its goal"
            self._server.set_aborted(GoToResult(progress), why)

    def preempt(self) -> None:
        """Preempt the client's goal: another one has replaced it."""
        if self._server is not None and self._server.is_active():
            self._server.set_preempted(GoToResult(), "another goal was set")
