#!/usr/bin/env python3
"""A robot and its controller come up in order; without the robot, its controller does not run."""

import os
import signal
import unittest

import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from bot_controller_demo_msgs.msg import GoToActionGoal, GoToActionResult
from bot_controller_demo_msgs.srv import SetGoal
from lifecycle_msgs.msg import State
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from nodekit_msgs.srv import ManageNodes, ManageNodesRequest

SIMULATOR, CONTROLLER = "/diff_drive", "/proportional_controller"
#: Messages of the action's state, which come at 5 Hz.
SOME = 4
#: Messages of odometry, which come at 30 Hz.
A_SECOND = 30


class ManagedRobot(unittest.TestCase):
    def setUp(self) -> None:
        # A busy machine may hold the simulator up for longer than the manager waits as a rule.
        rospy.set_param("/manager/heartbeat_timeout", 3.0)
        self.state = self.recorder(CONTROLLER + "/state", State)
        self.odometry = self.recorder("/odom", Odometry)
        self.commands = self.recorder("/cmd_vel", Twist)
        self.status = self.recorder("/go_to/status", GoalStatusArray)
        self.results = self.recorder("/go_to/result", GoToActionResult)
        self.goals = rospy.Publisher("/go_to/goal", GoToActionGoal, queue_size=1)
        self.addCleanup(self.goals.unregister)

    def recorder(self, topic: str, kind: type) -> MessageRecorder:
        made = MessageRecorder(topic, kind)
        self.addCleanup(made.close)
        return made

    def wait_until_it_drives(self) -> None:
        """Wait until both are active and the robot moves; clear earlier messages."""

        def is_active() -> bool:
            try:
                return bool(rospy.ServiceProxy("/manager/is_active", Trigger)().success)
            except rospy.ServiceException:
                return False  # it is just coming up

        wait_until(is_active, lambda: f"not active: {self.state.messages()[-3:]}")
        self.odometry.clear()
        self.odometry.wait_for(lambda message: message.twist.twist.linear.x > 0.0)
        self.commands.clear()
        self.commands.wait_for(lambda command: command.linear.x > 0.0)
        for recorder in (self.state, self.commands):
            recorder.clear()

    def wait_until_it_is_down(self) -> None:
        """Wait until the controller has been cleaned up, and has stopped the robot before."""
        self.state.wait_for(lambda state: state.label == "unconfigured")
        self.commands.wait_for(lambda command: command == Twist())

    def assert_it_stands(self) -> None:
        """Check that the reactivated controller does not move the robot."""
        self.state.wait_for(lambda state: state.label == "active")
        self.odometry.clear()
        self.commands.clear()
        wait_until(lambda: self.odometry.count() >= A_SECOND, lambda: "no odometry")
        self.assertEqual(self.commands.messages(), [])
        self.assertEqual(self.odometry.messages()[-1].twist.twist, Twist())

    def send(self, name: str) -> None:
        """Send a goal of the action."""
        wait_until(self.goals.get_num_connections, lambda: "no node takes goals")
        goal = GoToActionGoal()
        goal.goal_id.id, goal.goal_id.stamp = name, rospy.Time.now()
        goal.goal.target_pose.pose.position.x = 100.0
        goal.goal.target_pose.pose.orientation.w = 1.0
        self.goals.publish(goal)

    def act(self, name: str) -> None:
        """Send a goal of the action, and wait until it is pursued."""
        self.send(name)

        def is_pursued(array: GoalStatusArray) -> bool:
            return any(
                each.goal_id.id == name and each.status == GoalStatus.ACTIVE
                for each in array.status_list
            )

        self.status.wait_for(is_pursued)
        self.status.clear()
        wait_until(lambda: self.status.count() >= SOME, lambda: "no state of the action")
        # One server tells of it: a second one, left behind, would not pursue it.
        for array in self.status.messages():
            self.assertTrue(is_pursued(array), array)

    def assert_aborted(self, name: str) -> None:
        """See that a goal ends, because the controller is not active."""
        status = self.results.wait_for(lambda each: each.status.goal_id.id == name).status
        self.assertEqual(status.status, GoalStatus.ABORTED)
        self.assertEqual(status.text, "the node is not active")

    def test_robot_that_is_away_takes_its_controller_down_until_it_is_back(self) -> None:
        with launched("bot_controller_demo managed_robot.launch goal_x:=100 autostart:=ON") as run:
            self.wait_until_it_drives()
            self.act("first")
            with self.subTest("killed"):
                before = run.processes()[SIMULATOR]
                os.kill(before.pid, signal.SIGKILL)
                self.wait_until_it_is_down()
                self.assert_aborted("first")
                run.wait_for_new_process(SIMULATOR, before)
                self.wait_until_it_drives()
            self.act("second")
            with self.subTest("stopped"):
                simulator = run.processes()[SIMULATOR].pid
                with hanging(simulator):
                    self.wait_until_it_is_down()
                self.wait_until_it_drives()
                self.assertEqual(run.processes()[SIMULATOR].pid, simulator)
            with self.subTest("paused"):
                rospy.wait_for_service("/manager/manage_nodes", TIMEOUT_S)
                manage = rospy.ServiceProxy("/manager/manage_nodes", ManageNodes)
                self.assertTrue(manage(ManageNodesRequest.PAUSE).success)
                # Not because of old odometry: this is what the controller says last.
                wait_until(
                    lambda: self.commands.messages()[-1:] == [Twist()],
                    lambda: f"it drives on: {self.commands.messages()[-3:]}",
                )
                self.assertTrue(manage(ManageNodesRequest.RESUME).success)
                self.wait_until_it_drives()
            self.act("third")
            with self.subTest("paused while the action drives"):
                self.assertTrue(manage(ManageNodesRequest.PAUSE).success)
                self.assert_aborted("third")
                self.send("while paused")
                self.assert_aborted("while paused")
                self.assertTrue(manage(ManageNodesRequest.RESUME).success)
                self.assert_it_stands()
                set_goal = rospy.ServiceProxy(CONTROLLER + "/set_goal", SetGoal)
                self.assertTrue(set_goal(100.0, 0.0, 0.0).success)
                self.wait_until_it_drives()


if __name__ == "__main__":
    rospy.init_node("test_managed_robot")
    rosrun("bot_controller_demo", "managed_robot", ManagedRobot)
