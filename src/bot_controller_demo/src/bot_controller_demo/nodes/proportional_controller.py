"""Proportional controller node: drives a robot to a goal."""

import math

import rospy
from geometry_msgs.msg import PoseStamped

from bot_controller_demo.driving.driver import Driver
from bot_controller_demo.driving.go_to_server import GoToServer
from bot_controller_demo.driving.goals import FARTHEST, GoalRefused, allowed, goal_of
from bot_controller_demo.driving.parameters import DrivingParameters
from bot_controller_demo.control.geometry import Goal
from bot_controller_demo_msgs.srv import SetGoal, SetGoalRequest, SetGoalResponse
from nodekit import FloatParameter, Node, run


def _coordinate(default: float, unit: str, what: str) -> FloatParameter:
    return FloatParameter(default, minimum=-FARTHEST, maximum=FARTHEST, unit=unit, help=what)


class ProportionalControllerParameters(DrivingParameters):
    """Parameters of proportional_controller: goal and driving."""

    goal_x = _coordinate(
        2.0, "m", "x of the goal; the robot drives there at the start, and after a change"
    )
    goal_y = _coordinate(1.0, "m", "y of the goal")
    goal_theta = _coordinate(math.pi / 2.0, "rad", "heading at the goal")

    @property
    def goal(self) -> Goal:
        """Target pose."""
        return Goal(self.goal_x, self.goal_y, self.goal_theta)


class ProportionalController:
    """Drives to the goal in its parameters, and then to other goals on request.

    :ROS Subscribers:
        - ``~goal`` (geometry_msgs/PoseStamped), in the frame of the odometry; rviz sends it

    :ROS Services:
        - ``~set_goal`` (bot_controller_demo_msgs/SetGoal)

    :ROS Actions:
        - ``go_to`` (bot_controller_demo_msgs/GoTo)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ProportionalControllerParameters`

    For its other topics see :class:`.Driver`.
    """

    def __init__(self, node: Node) -> None:
        parameters = node.declare_parameters(ProportionalControllerParameters, self._on_change)
        self._go_to = GoToServer(node, self._accept, self._stop)
        self._driver = Driver(node, parameters)
        node.create_subscription("~goal", PoseStamped, self._on_goal)
        node.create_service("~set_goal", SetGoal, self._set_goal)
        node.create_timer(lambda: parameters.values.control_frequency, self._step)
        self._driver.head_for(parameters.values.goal)

    def _step(self, _elapsed: float) -> None:
        self._go_to.poll()
        self._go_to.publish_progress(self._driver.step())

    def _on_change(
        self, new: ProportionalControllerParameters, old: ProportionalControllerParameters
    ) -> None:
        if new.goal != old.goal:
            self._head_for(new.goal)

    def _on_goal(self, message: PoseStamped) -> None:
        try:
            self._head_for(goal_of(message, self._driver.frame))
        except GoalRefused as error:
            rospy.logwarn("ignoring the goal: %s", error)

    def _set_goal(self, request: SetGoalRequest) -> SetGoalResponse:
        goal = Goal(request.x, request.y, request.theta)
        try:
            self._head_for(allowed(goal))
        except GoalRefused as error:
            return SetGoalResponse(False, str(error))
        return SetGoalResponse(True, str(goal))

    def _head_for(self, goal: Goal) -> None:
        """Drive to a goal that is not from the action."""
        self._go_to.preempt()
        self._driver.head_for(goal)

    def _stop(self) -> None:
        self._driver.stop()

    def _accept(self, pose: PoseStamped) -> None:
        """Drive to a goal of the action."""
        self._driver.head_for(goal_of(pose, self._driver.frame))


def main() -> None:
    """Run the node until it is shut down."""
    run("proportional_controller", ProportionalController)
