"""Node that sends the robot to a goal, and logs its progress until it arrives."""

import math
from typing import Optional

import rospy
from geometry_msgs.msg import PoseStamped

from bot_controller_demo_msgs.msg import Progress
from bot_controller_demo_msgs.srv import SetGoal, SetGoalRequest
from nodekit import (
    CallCancelled,
    CallError,
    CallFuture,
    FloatParameter,
    Node,
    ParameterSet,
    abort,
    run,
)

_CONTROLLER = "proportional_controller"
#: Phase of a goal that is given up.
_GIVEN_UP = "given_up"
#: Time without progress messages until that is logged [s].
_SILENCE_S = 3.0


def _coordinate(unit: str, what: str) -> FloatParameter:
    return FloatParameter(0.0, minimum=-1e6, maximum=1e6, unit=unit, help=what)


class RobotControlParameters(ParameterSet):
    """Parameters of robot_control; a change sends the robot to the new goal."""

    x = _coordinate("m", "x of the goal, in the frame of the odometry")
    y = _coordinate("m", "y of the goal")
    theta = _coordinate("rad", "heading at the goal")

    def is_at(self, pose: PoseStamped) -> bool:
        """Return whether a pose is this goal.

        :param pose: a goal published by the controller
        """
        position, turn = pose.pose.position, pose.pose.orientation
        angle = 2.0 * math.atan2(turn.z, turn.w) - self.theta
        return (position.x, position.y) == (self.x, self.y) and math.cos(angle) > 1.0 - 1e-9


class RobotControl:
    """Calls the controller until it accepts the goal; ends on arrival, with status 0.

    It ends with status 1 if the controller aborts the goal, or another client sets another goal.

    :ROS Services called:
        - ``proportional_controller/set_goal`` (bot_controller_demo_msgs/SetGoal)

    :ROS Subscribers:
        - ``proportional_controller/progress`` (bot_controller_demo_msgs/Progress)
        - ``proportional_controller/current_goal`` (geometry_msgs/PoseStamped)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`RobotControlParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(RobotControlParameters, self._on_change)
        self._client = node.create_client(_CONTROLLER + "/set_goal", SetGoal)
        self._progress = Progress()
        self._call: Optional[CallFuture] = None
        self._set_at: Optional[rospy.Time] = None
        self._heard_at = rospy.Time()
        node.create_subscription(_CONTROLLER + "/current_goal", PoseStamped, self._on_goal)
        node.create_subscription(_CONTROLLER + "/progress", Progress, self._on_progress)
        node.create_timer(1.0, self._tick)

    def _tick(self, _elapsed: float) -> None:
        if self._set_at is not None:
            silence = (rospy.Time.now() - max(self._set_at, self._heard_at)).to_sec()
            if silence > _SILENCE_S:
                rospy.logwarn("the controller has told no progress for %.0f s", silence)
            elif self._heard_at > self._set_at:
                rospy.loginfo("%s: %.2f m are left", self._progress.phase, self._progress.distance)
        elif self._call is None:
            goal = self._parameters.values
            self._call = self._client.call_async(SetGoalRequest(goal.x, goal.y, goal.theta))
            self._call.add_done_callback(self._on_answer)

    def _on_answer(self, call: CallFuture) -> None:
        if call is not self._call:
            return  # the answer is about a previous goal
        self._call = None
        try:
            answer = call.result()
        except CallCancelled:
            return  # cancelled by the node's shutdown
        except CallError as error:
            rospy.logwarn("cannot send the robot: %s", error)
            return
        if not answer.success:
            rospy.logwarn("cannot send the robot: %s", answer.message)
            return
        rospy.loginfo("the robot goes to %s", answer.message)
        self._set_at = rospy.Time.now()

    def _on_goal(self, goal: PoseStamped) -> None:
        # The topic is latched, so an earlier goal arrives, too.
        is_new = self._set_at is not None and goal.header.stamp > self._set_at
        if is_new and not self._parameters.values.is_at(goal):
            where = goal.pose.position
            abort(f"the robot was sent elsewhere: to x {where.x:g} m, y {where.y:g} m")

    def _on_progress(self, progress: Progress) -> None:
        self._progress, self._heard_at = progress, rospy.Time.now()
        # Earlier messages are about the previous goal.
        is_new = self._set_at is not None and progress.header.stamp > self._set_at
        if is_new and progress.phase == Progress.ARRIVED:
            rospy.signal_shutdown("arrived")
        elif is_new and progress.phase == _GIVEN_UP:
            abort(f"the robot makes no progress: {progress.distance:.2f} m are left")

    def _on_change(self, new: RobotControlParameters, old: RobotControlParameters) -> None:
        self._set_at = self._call = None


def main() -> None:
    """Run the node until the robot has arrived, or the goal is aborted."""
    run("robot_control", RobotControl)
