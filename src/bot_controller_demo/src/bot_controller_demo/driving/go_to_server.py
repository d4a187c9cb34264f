"""The action go_to, where Debian's python3-actionlib is installed."""

from typing import Any, Callable, Optional

import rospy

from bot_controller_demo.driving.goals import GoalRefused
from bot_controller_demo.control.goal_controller import ARRIVED
from bot_controller_demo.control.progress_checker import GIVEN_UP
from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToResult, Progress
from nodekit import Node

try:
    import actionlib
except ImportError:
    actionlib = None

_NOT_ACTIVE = "the controller is not active"


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
        self._is_polled = False
        if actionlib is None:
            rospy.logwarn("no action go_to: python3-actionlib is not installed; the rest works")
            return
        self._server = actionlib.SimpleActionServer(
            node.resolve("go_to"), GoToAction, auto_start=False
        )
        self._server.register_goal_callback(self._refuse_unpolled)
        node.own(self)
        node.before_deactivate(self.abort)

    def poll(self) -> None:
        """Handle what clients have requested since the last call."""
        server = self._server
        if server is None:
            return
        self._is_polled = True
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
        """Abort all goals: a node that stops being active may never be so again."""
        if self._server.is_active():
            self._stop()
        with self._server.action_server.lock:  # as the thread has that brings a goal
            self._is_polled = False
            self._end_goals(self._server.set_aborted, _NOT_ACTIVE)

    def _refuse_unpolled(self) -> None:
        """Reject a new goal while the server is not polled: it would be driven to much later."""
        if not self._is_polled:
            self._end_goals(self._server.set_aborted, _NOT_ACTIVE)

    def _end_goals(self, end: Callable[[Any, str], None], why: str) -> None:
        """End the goal that is pursued, and the one that waits to be polled."""
        with self._server.action_server.lock:
            if self._server.is_active():
                end(GoToResult(), why)
            if self._server.is_new_goal_available():
                self._server.accept_new_goal()
                end(GoToResult(), why)

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
        """Preempt the goals of clients: another one has replaced them."""
        if self._server is not None:
            self._end_goals(self._server.set_preempted, "another goal was set")
