"""Goal controller with its ROS topics."""

import math
from typing import Any, Optional

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from bot_controller_demo.driving.commands import Commands
from bot_controller_demo.driving.parameters import DrivingParameters
from bot_controller_demo.control.staleness import Staleness
from bot_controller_demo.control.geometry import Goal, Pose, heading_of, pose_fault
from bot_controller_demo.control.goal_controller import ARRIVED, Guidance, GoalController
from bot_controller_demo.control.progress_checker import GIVEN_UP, ProgressChecker
from bot_controller_demo.control.steering import COURSE_LEAST_TOLERANCE, COURSE_RATIOS, may_circle
from bot_controller_demo.control.velocities import STOP
from bot_controller_demo_msgs.msg import Progress
from nodekit import LiveParameters, Node

#: Frame of the odometry before the first message.
_ODOM = "odom"


class Driver:
    """Drives to one goal at a time, and stays there; a new goal replaces the last one.

    A goal without progress for ``~no_progress_timeout``, for example behind a wall, is given up:
    the robot is stopped.

    :ROS Subscribers:
        - ``odom`` (nav_msgs/Odometry); the robot stops while it is older than ``~odom_timeout``

    :ROS Publishers:
        - ``cmd_vel`` (geometry_msgs/Twist, or TwistStamped): while it drives, and one zero to stop
        - ``~progress`` (bot_controller_demo_msgs/Progress): with each command, at the goal, and
            when a goal is given up
        - ``~arrived`` (std_msgs/Bool), latched
        - ``~current_goal`` (geometry_msgs/PoseStamped), latched

    :param node: the node
    :param parameters: a set of :class:`.DrivingParameters`

    :ivar frame: frame of the odometry, None before the first message
    """

    def __init__(self, node: Node, parameters: "LiveParameters[Any]") -> None:
        self._parameters = parameters
        self._commands = Commands(node, parameters.values.controller_type)
        self._progress = node.create_publisher("~progress", Progress)
        self._progress_message = Progress()
        self._arrived = node.create_publisher("~arrived", Bool, latch=True)
        self._current_goal = node.create_publisher("~current_goal", PoseStamped, latch=True)
        self._controller: Optional[GoalController] = None
        self._pose = Pose(0.0, 0.0, 0.0)
        self._stamp = rospy.Time()
        self._staleness = Staleness()
        self._progress_checker = ProgressChecker()
        self.frame: Optional[str] = None
        self._odometry_name = node.resolve("odom")
        #: Why the latest message is invalid; empty if it is valid.
        self._fault = ""
        #: Last logged reason for waiting; empty while the robot does not wait.
        self._missing = ""
        self._checked: Optional[DrivingParameters] = None
        node.create_subscription("odom", Odometry, self._on_odometry)

    def head_for(self, goal: Goal) -> None:
        """Drive to a goal.

        :param goal: in the frame of the odometry
        """
        rospy.loginfo("goal: %s", goal)
        self._controller = GoalController(goal)
        self._progress_checker.forget()
        self._arrived.publish(Bool(False))
        self._publish_goal(goal)

    def _publish_goal(self, goal: Goal) -> None:
        message = PoseStamped()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = self.frame or _ODOM
        message.pose.position.x = goal.x
        message.pose.position.y = goal.y
        theta = goal.theta or 0.0
        message.pose.orientation.z, message.pose.orientation.w = (
            math.sin(theta / 2.0),
            math.cos(theta / 2.0),
        )
        self._current_goal.publish(message)

    def stop(self) -> None:
        """Stop the robot, and clear the goal."""
        self._controller = None
        self._commands.publish(STOP)

    def step(self) -> Optional[Progress]:
        """Command the robot; to be called ``~control_frequency`` times a second.

        :returns: the progress, the same message each time; None without a goal, after the
            goal was given up, or while the pose is unknown
        """
        settings: DrivingParameters = self._parameters.values
        self._warn_of_circling(settings)
        if self._controller is None or not self._has_odometry(settings.odom_timeout):
            return None
        before = self._controller.phase
        guidance = self._controller.step(self._pose, settings.tuning)
        phase = guidance.phase
        if self._makes_no_progress(guidance, settings.no_progress_timeout):
            phase = GIVEN_UP
            self.stop()
        else:
            self._commands.publish(guidance.velocity)
        progress = self._progress_message
        progress.phase = phase
        progress.distance = guidance.errors.distance
        progress.heading_error = guidance.errors.heading
        progress.header.stamp = self._stamp
        progress.header.frame_id = self.frame
        left = f"{progress.distance:.3f} m and {progress.heading_error:.3f} rad are left"
        if phase == GIVEN_UP:
            rospy.logwarn(
                "no progress for %g s: the goal is given up and the robot stopped; %s",
                settings.no_progress_timeout,
                left,
            )
        elif (phase == ARRIVED) != (before == ARRIVED):
            self._arrived.publish(Bool(phase == ARRIVED))
            rospy.loginfo("%s: %s", phase, left)
        self._progress.publish(progress)
        return progress

    def _makes_no_progress(self, guidance: Guidance, limit: float) -> bool:
        """Return whether the robot has made no progress for a time [s]; 0 disables the check."""
        if guidance.phase == ARRIVED:
            self._progress_checker.forget()
            return False
        lasted = self._progress_checker.lasted(guidance.phase, guidance.errors, rospy.get_time())
        return 0.0 < limit <= lasted

    def _on_odometry(self, message: Odometry) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        parts = (turn.x, turn.y, turn.z, turn.w)
        self._fault = pose_fault((position.x, position.y), parts)
        if self._fault:
            return  # so the odometry becomes stale
        self._pose = Pose(position.x, position.y, heading_of(*parts))
        self._stamp = message.header.stamp or rospy.Time.now()
        self._staleness.record_message(message.header.stamp.to_sec(), rospy.get_time())
        guess, self.frame = self.frame or _ODOM, message.header.frame_id
        if self.frame != guess and self._controller is not None:
            self._publish_goal(self._controller.goal)

    def _has_odometry(self, limit: float) -> bool:
        """Return whether the robot's pose is known; if not, stop it and log that once."""
        now = rospy.get_time()
        age, skew = self._staleness.age(now), self._staleness.skew(now, limit)
        if age <= limit:
            if self._missing:
                rospy.loginfo("receiving odometry: the robot drives")
            self._missing = ""
            return True
        self._progress_checker.forget()
        self._commands.publish(STOP)
        name = self._odometry_name
        if self._fault:
            missing = "pose"
            text = f"{name} cannot be used ({self._fault}): the robot is stopped"
        elif math.isinf(age):
            missing, text = "first", f"waiting for odometry on {name}"
        elif skew:
            missing = "clock"
            text = (
                f"{name} has stamps {skew:.2f} s behind this clock: the robot is stopped; "
                "set the clocks of both machines alike"
            )
        else:
            missing = "next"
            text = f"{name} is {age:.2f} s old: the robot is stopped until there is a new message"
        if missing != self._missing:
            self._missing = missing
            log = rospy.loginfo if missing == "first" else rospy.logwarn
            log("%s", text)
        return False

    def _warn_of_circling(self, settings: DrivingParameters) -> None:
        """Warn once per change of settings if the law may circle its goal."""
        if settings is self._checked:
            return
        self._checked = settings
        tuning = settings.tuning
        if tuning.law == "course" and may_circle(tuning.gains, tuning.linear_tolerance):
            rospy.logwarn(
                "control_law course may circle its goal with kp_linear %g 1/s, kp_angular %g 1/s "
                "and linear_tolerance %g m: kp_angular must be %g to %g times kp_linear and "
                "linear_tolerance at least %g m; or use the law settling",
                *tuning.gains,
                tuning.linear_tolerance,
                *COURSE_RATIOS,
                COURSE_LEAST_TOLERANCE,
            )
