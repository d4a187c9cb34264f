#!/usr/bin/env python3
"""Robots and their controllers on the wire."""

import math
import os
import unittest
from typing import Any, List

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from stepping import STEPS_HZ, SteppedClock

from bot_controller_demo.driving.commands import Commands
from bot_controller_demo.control.progress_checker import GIVEN_UP
from bot_controller_demo.control.straight_line import distance_left
from bot_controller_demo.control.velocities import STOP, Velocity
from bot_controller_demo.control.wandering import Wanderer
from bot_controller_demo_msgs.msg import (
    GoToActionFeedback,
    GoToActionGoal,
    GoToActionResult,
    Progress,
)
from bot_controller_demo_msgs.srv import SetGoal
from nodekit import Names, Node
from nodekit.testing.changing import change as change_parameters
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, hanging
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import wait_until
from nodekit_msgs.srv import SetParameters

CONTROLLER = "/lab/proportional_controller"
ODOM, CMD_VEL, PROGRESS = "/lab/odom", "/lab/cmd_vel", CONTROLLER + "/progress"
WAY_ODOM, WAY_PROGRESS = "/way/odom", "/way/waypoint_controller/progress"
#: Progress has the stamp of the odometry: it may be one sample of either, 1/20 and 1/30 s, behind.
FRESH_HZ = 12.0
SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")


def pose(x: float, y: float, theta: float, frame: str = "odom") -> PoseStamped:
    """Return a goal as a message."""
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.z = math.sin(theta / 2.0)
    message.pose.orientation.w = math.cos(theta / 2.0)
    return message


def heading(odometry: Odometry) -> float:
    """Return the heading of a robot [rad]."""
    turn = odometry.pose.pose.orientation
    return 2.0 * math.atan2(turn.z, turn.w)


class Robots(unittest.TestCase):
    """Each test begins with a robot at rest at the origin."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.graph = Graph()
        cls.clock = clock = SteppedClock()
        clock.subscribe(ODOM, Odometry, 30.0)
        clock.subscribe(CMD_VEL, TwistStamped, 0.0)
        clock.subscribe(PROGRESS, Progress, FRESH_HZ)
        clock.subscribe(WAY_ODOM, Odometry, 30.0)
        clock.subscribe(WAY_PROGRESS, Progress, FRESH_HZ)
        cls.arrived = MessageRecorder(CONTROLLER + "/arrived", Bool)
        cls.current = MessageRecorder(CONTROLLER + "/current_goal", PoseStamped)
        cls.log = MessageRecorder("/rosout", Log)
        cls.goals = rospy.Publisher(CONTROLLER + "/goal", PoseStamped, queue_size=10)
        cls.odometries = rospy.Publisher(ODOM, Odometry, queue_size=10)
        cls.actions = rospy.Publisher("/lab/go_to/goal", GoToActionGoal, queue_size=10)
        cls.cancel = rospy.Publisher("/lab/go_to/cancel", GoalID, queue_size=10)
        cls.result = MessageRecorder("/lab/go_to/result", GoToActionResult)
        cls.feedback = MessageRecorder("/lab/go_to/feedback", GoToActionFeedback)
        cls.set_goal = rospy.ServiceProxy(CONTROLLER + "/set_goal", SetGoal)
        cls.reset = rospy.ServiceProxy("/lab/diff_drive/reset", Trigger)
        clock.begin()
        publishers = (cls.goals, cls.actions, cls.cancel, cls.odometries)
        wait_until(
            lambda: all(one.get_num_connections() for one in publishers), lambda: "not connected"
        )
        recorders = [f"/lab/go_to/{name}" for name in ("result", "feedback")]
        for topic in (*recorders, CONTROLLER + "/arrived", "/rosout"):
            cls.graph.wait_until_heard(CONTROLLER, topic, rospy.get_name())

    def setUp(self) -> None:
        self.assertTrue(self.set_goal(0.0, 0.0, 0.0).success)
        self.reset()  # or it would drive there
        self.until(self.is_at_home, "not at home", 10.0, PROGRESS)
        self.clock.forget()
        for recorder in (self.log, self.result, self.feedback, self.arrived):
            recorder.clear()

    def is_at_home(self) -> bool:
        """Return whether the last message, the only one kept, is from a robot at rest."""
        odometry, progress = self.odometry(), self.clock.heard(PROGRESS)[-1]
        place = odometry.pose.pose.position
        errors = (place.x, place.y, heading(odometry), progress.distance, progress.heading_error)
        if any(errors) and progress.phase == "arrived" and odometry.twist.twist == Twist():
            self.reset()  # a command of before had it drive a little
        return not any(errors)

    def until(self, condition: Any, what: str, longest: float = 40.0, *but: str) -> Any:
        return self.clock.step_until(condition, what, longest, *but)

    def phase(self) -> str:
        return str(self.clock.heard(PROGRESS)[-1].phase)

    def odometry(self) -> Odometry:
        return self.clock.heard(ODOM)[-1]

    def commands(self, since: float = 0.0) -> List[Velocity]:
        heard = self.clock.heard(CMD_VEL)
        twists = [message.twist for message in heard if message.header.stamp.to_sec() > since]
        return [Velocity(twist.linear.x, twist.angular.z) for twist in twists]

    def drive(self, longest: float = 40.0) -> None:
        """Let the robot drive until it arrives, and check that it has."""
        self.until(lambda: self.phase() == "driving" or self.phase() == "turning", "it stays", 1.0)
        self.until(lambda: self.phase() == "arrived", "it does not arrive", longest)
        told = self.arrived.messages
        wait_until(lambda: [m.data for m in told()][-2:] == [False, True], lambda: str(told()))
        self.assertLessEqual(self.clock.heard(PROGRESS)[-1].distance, 0.1)

    def logged(self, *words: str) -> None:
        """Wait for a line of the log."""
        self.log.wait_for(lambda line: all(word in line.msg for word in words))

    @extended
    def test_five_metres_straight_are_the_closed_form(self) -> None:
        """Course 001-robot-6, 001-robot-8."""
        since = self.clock.now  # the stop at home may come after it
        self.assertIn("x 5 m, y 0 m, theta 0 rad", self.set_goal(5.0, 0.0, 0.0).message)
        self.drive()
        for _ in range(12):
            self.clock.step()  # in which no second stop is sent
        stamps = [message.header.stamp.to_sec() for message in self.clock.heard(ODOM)]
        places = [message.pose.pose.position for message in self.clock.heard(ODOM)]
        start = next(stamp for stamp, place in zip(stamps, places) if place.x > 0.0)
        driven = [(stamp - start, place) for stamp, place in zip(stamps, places) if stamp >= start]
        self.assertGreater(driven[-1][0], 23.0)
        for elapsed, place in driven:
            left = max(distance_left(elapsed, 5.0, 0.5, 0.22), 0.1)
            self.assertAlmostEqual(5.0 - place.x, left, delta=0.015, msg=f"after {elapsed} s")
            self.assertAlmostEqual(place.y, 0.0, delta=1e-9)
        commands = self.clock.heard(CMD_VEL)
        self.assertEqual(commands[-1].header.frame_id, "base_footprint")
        told = self.commands(since)
        moving = told[next(number for number, command in enumerate(told) if command.linear) :]
        self.assertEqual((moving.count(Velocity(0.0, 0.0)), moving[-1]), (1, (0.0, 0.0)))

    def test_goal_behind_by_parameters(self) -> None:
        change = rospy.ServiceProxy(CONTROLLER + "/change", SetParameters)
        self.assertTrue(change("{goal_x: -0.5, goal_y: 0.0, goal_theta: 3.0}").success)
        self.drive()
        self.assertAlmostEqual(self.odometry().pose.pose.position.x, -0.45, delta=0.06)
        self.assertAlmostEqual(heading(self.odometry()), 3.0, delta=0.06)
        refused = change("{kp_linear: 20.0}")
        self.assertFalse(refused.success)
        self.assertIn("both gains must be below control_frequency", refused.message)

    def test_goal_is_told_in_the_frame_that_the_odometry_has(self) -> None:
        self.addCleanup(self.until, lambda: self.odometry().header.frame_id == "odom", "prefix")
        self.addCleanup(change_parameters, "/lab/diff_drive", frame_prefix="")
        self.set_goal(0.0, 0.0, 0.5)
        self.current.wait_for(lambda goal: goal.header.frame_id == "odom")
        change_parameters("/lab/diff_drive", frame_prefix="lab/")
        self.until(lambda: self.odometry().header.frame_id == "lab/odom", "no prefix")
        told = self.current.wait_for(lambda goal: goal.header.frame_id == "lab/odom")
        # Late subscribers receive it, too.
        late = MessageRecorder(CONTROLLER + "/current_goal", PoseStamped)
        late.wait_for(lambda goal: goal.header.frame_id == "lab/odom")
        late.close()
        self.assertAlmostEqual(told.pose.orientation.z, math.sin(0.25))

    def test_turn_by_pi_by_topic_and_goals_that_are_refused(self) -> None:
        since = self.clock.now
        self.goals.publish(pose(0.0, 0.0, math.pi))
        self.drive(10.0)
        self.assertAlmostEqual(abs(heading(self.odometry())), math.pi, delta=0.06)
        turns = [command.angular for command in self.commands(since) if command.angular]
        self.assertEqual(len({turn > 0.0 for turn in turns}), 1)
        self.goals.publish(pose(1.0, 0.0, 0.0, "map"))
        self.logged("ignoring the goal", "frame_id 'map': must be 'odom'")
        self.goals.publish(pose(math.nan, 0.0, 0.0))
        self.logged("ignoring the goal", "must be in [-1e6, 1e6]")
        self.goals.publish(PoseStamped())
        self.logged("ignoring the goal", "must be a quaternion")
        answer = self.set_goal(math.inf, 0.0, 0.0)
        self.assertFalse(answer.success)
        self.assertIn("must be in [-1e6, 1e6]", answer.message)
        self.clock.step()
        self.assertEqual(self.phase(), "arrived")

    def act(self, name: str, target: PoseStamped) -> None:
        """Send a goal of the action, and wait until it is pursued."""
        goal = GoToActionGoal()
        goal.goal_id.id, goal.goal_id.stamp = name, rospy.Time.from_sec(self.clock.now)
        goal.goal.target_pose = target
        self.actions.publish(goal)

    def outcome(self, name: str) -> GoToActionResult:
        """Return the result of a goal, stepping until it exists."""

        def results() -> List[GoToActionResult]:
            return [one for one in self.result.messages() if one.status.goal_id.id == name]

        return self.until(results, f"no result of {name}", 40.0, PROGRESS)[0]

    def replace_within_a_period(self, name: str) -> None:
        """Replace a goal of the action before the controller has polled."""
        heard = len(self.clock.heard(PROGRESS))
        self.until(lambda: len(self.clock.heard(PROGRESS)) > heard, "no progress")
        # Now the clock stands. Once a goal is told that another one has come, that one is there.
        for each in ("before", name):
            self.act(each, pose(2.0, 0.0, 0.0))
        self.result.wait_for(lambda one: one.status.goal_id.id == "before")
        self.assertTrue(self.set_goal(1.0, 0.0, 0.0).success)
        self.assertEqual(self.outcome(name).status.text, "another goal was set")

    def told_of(self, name: str) -> bool:
        return any(one.status.goal_id.id == name for one in self.feedback.messages())

    def test_action_with_feedback_preemption_and_refusal(self) -> None:
        self.act("first", pose(3.0, 0.0, 0.0))
        self.until(lambda: self.told_of("first"), "no feedback")
        self.assertGreater(self.feedback.messages()[0].feedback.progress.distance, 2.5)
        self.act("second", pose(-3.0, 0.0, 0.0))
        self.assertEqual(self.outcome("first").status.status, GoalStatus.PREEMPTED)
        self.until(lambda: self.told_of("second"), "no feedback")
        self.cancel.publish(GoalID(id="second"))
        self.assertEqual(self.outcome("second").status.status, GoalStatus.PREEMPTED)
        self.until(lambda: self.commands()[-1] == (0.0, 0.0), "it drives on", 1.0, PROGRESS)
        self.act("third", pose(2.0, 0.0, 0.0, "map"))
        aborted = self.outcome("third")
        self.assertEqual(aborted.status.status, GoalStatus.ABORTED)
        self.assertIn("frame_id 'map'", aborted.status.text)
        self.set_goal(3.0, 0.0, 0.0)
        self.until(lambda: self.commands()[-1].linear > 0.0, "it stays", 5.0, PROGRESS)
        self.act("nowhere", pose(2.0, 0.0, 0.0, "map"))
        self.assertEqual(self.outcome("nowhere").status.status, GoalStatus.ABORTED)
        self.logged("ignoring the goal", "frame_id 'map'")
        for _ in range(6):
            self.clock.step()
        self.assertGreater(self.commands()[-1].linear, 0.0, "it was told to stop")
        self.act("fourth", pose(2.0, 0.0, 0.0))
        self.until(lambda: self.told_of("fourth"), "no feedback", 5.0, PROGRESS)
        self.set_goal(1.0, 0.0, 0.0)
        self.assertEqual(self.outcome("fourth").status.text, "another goal was set")
        self.replace_within_a_period("not polled")
        self.act("fifth", pose(0.3, 0.0, 0.0))
        self.until(lambda: self.told_of("fifth"), "no feedback")
        fifth = self.outcome("fifth")
        self.assertEqual(fifth.status.status, GoalStatus.SUCCEEDED)
        self.assertLessEqual(fifth.result.progress.distance, 0.1)

    def test_goal_that_is_refused_stops_the_robot_that_the_action_drives(self) -> None:
        self.act("there", pose(3.0, 0.0, 0.0))
        self.until(lambda: self.told_of("there"), "no feedback")
        self.until(lambda: self.commands()[-1].linear > 0.0, "it stays", 5.0)
        self.act("off the map", pose(2.0, 0.0, 0.0, "map"))
        self.assertEqual(self.outcome("off the map").status.status, GoalStatus.ABORTED)
        self.assertEqual(self.outcome("there").status.status, GoalStatus.PREEMPTED)
        self.until(lambda: self.commands()[-1] == STOP, "it drives on", 1.0, PROGRESS)
        commands = len(self.commands())
        for _ in range(60):
            self.clock.step(PROGRESS)
        self.assertEqual(len(self.commands()), commands)
        self.assertEqual(self.odometry().twist.twist, Twist())

    def test_a_goal_behind_a_wall_is_aborted_and_the_robot_stands(self) -> None:
        self.addCleanup(change_parameters, "/lab/diff_drive", walls=[])
        self.addCleanup(change_parameters, CONTROLLER, no_progress_timeout=10.0)
        # Not on the parameter server: the robot would have driven on before it is told.
        change_parameters("/lab/diff_drive", walls=[[0.6, -5.0, 0.6, 5.0]])
        change_parameters(CONTROLLER, no_progress_timeout=3.0)
        self.act("behind", pose(2.0, 0.0, 0.0))
        aborted = self.outcome("behind")
        self.assertEqual(aborted.status.status, GoalStatus.ABORTED)
        self.assertIn("no progress: the robot has stopped 1.5", aborted.status.text)
        self.assertEqual(aborted.result.progress.phase, GIVEN_UP)
        self.logged("no progress for 3 s: the goal is given up and the robot stopped; 1.5")
        self.until(lambda: self.commands()[-1] == STOP, "it drives on", 1.0, PROGRESS)
        commands = len(self.commands())
        for _ in range(60):
            self.clock.step(PROGRESS)
        self.assertEqual(len(self.commands()), commands, "silence leaves the robot to others")
        self.assertEqual(self.odometry().twist.twist, Twist())
        self.assertEqual(self.phase(), GIVEN_UP)

    def test_new_goal_has_all_the_time_for_its_progress(self) -> None:
        self.addCleanup(change_parameters, "/lab/diff_drive", walls=[])
        self.addCleanup(change_parameters, CONTROLLER, no_progress_timeout=10.0)
        change_parameters("/lab/diff_drive", walls=[[0.2, -5.0, 0.2, 5.0]])
        change_parameters(CONTROLLER, no_progress_timeout=3.0)
        self.set_goal(2.0, 0.0, 0.0)
        self.until(lambda: self.odometry().twist.twist.linear.x > 0.0, "it stays")
        self.until(lambda: self.odometry().twist.twist == Twist(), "there is no wall")
        for _ in range(2 * STEPS_HZ):
            self.clock.step()
        self.set_goal(-3.0, 0.0, 0.0)  # further away than the one before
        self.until(lambda: self.odometry().pose.pose.position.x < 0.0, "it gave up", 20.0, PROGRESS)

    def test_old_odometry_stops_the_robot(self) -> None:
        self.addCleanup(change_parameters, CONTROLLER, no_progress_timeout=10.0)
        change_parameters(CONTROLLER, no_progress_timeout=1.0)
        self.set_goal(5.0, 0.0, 0.0)
        self.until(lambda: self.odometry().twist.twist.linear.x > 0.0, "it stays")
        simulator = self.graph.pid("/lab/diff_drive")
        with hanging(simulator):
            before, silent = self.clock.now, (ODOM, PROGRESS)
            self.until(lambda: self.commands()[-1] == (0.0, 0.0), "it drives on", 60.0, *silent)
            stopped = self.clock.heard(CMD_VEL)[-1].header.stamp.to_sec()
            self.assertGreaterEqual(stopped - before, 0.4)
            self.logged("/lab/odom is ", " s old: the robot is stopped")
            for _ in range(STEPS_HZ):  # which is not held against it when it drives again
                self.clock.step(*silent)
            broken = Odometry()
            broken.header.stamp = rospy.Time.from_sec(self.clock.now)
            broken.pose.pose.position.x = math.nan
            self.odometries.publish(broken)
            self.until(lambda: math.isnan(self.odometry().pose.pose.position.x), "?", 9.0, *silent)
            for _ in range(6):
                self.clock.step(*silent)
            self.assertNotEqual(self.phase(), "arrived")
        self.until(lambda: self.commands()[-1].linear > 0.0, "it stays", 10.0, *silent)
        self.logged("receiving odometry")

    def test_law_of_the_course_is_warned_of(self) -> None:
        change = rospy.ServiceProxy(CONTROLLER + "/change", SetParameters)
        self.addCleanup(change, "{control_law: settling, kp_linear: 0.5}")
        self.assertTrue(change("{control_law: course, kp_linear: 2.0}").success)
        self.until(
            lambda: [line for line in self.log.messages() if "may circle its goal" in line.msg],
            "no warning",
            5.0,
        )
        for _ in range(STEPS_HZ):
            self.clock.step()
        told = [line for line in self.log.messages() if "may circle its goal" in line.msg]
        self.assertEqual(len(told), 1)

    @extended
    def test_waypoints_are_gone_through_again_and_a_kill_stops_the_robot(self) -> None:
        commands = MessageRecorder("/way/cmd_vel", Twist)
        heard = self.clock.heard

        def has_arrived() -> bool:
            return heard(WAY_PROGRESS)[-1].phase == "arrived"

        self.until(has_arrived, "it does not arrive", 200.0)
        change_parameters("/way/waypoint_controller", waypoints=[[1.0, 0.0], [1.0, 0.5, 3.0]])
        self.until(lambda: not has_arrived(), "it does not start again", 60.0)
        ahead = [(1.0, 0.0), (1.0, 0.5)]

        def has_come_through() -> bool:
            place = heard(WAY_ODOM)[-1].pose.pose.position
            if ahead and math.hypot(place.x - ahead[0][0], place.y - ahead[0][1]) <= 0.11:
                ahead.pop(0)
            return not ahead and has_arrived()

        self.until(has_come_through, f"points are left: {ahead}", 60.0)
        self.assertAlmostEqual(heading(heard(WAY_ODOM)[-1]), 3.0, delta=0.06)
        change_parameters("/way/waypoint_controller", repeat=True)
        self.until(lambda: heard(WAY_ODOM)[-1].twist.twist.linear.x > 0.1, "it stays", 60.0)
        change = rospy.ServiceProxy("/way/waypoint_controller/change", SetParameters)
        self.assertTrue(change("{waypoints: []}").success)
        stands = Twist()
        silent = (WAY_PROGRESS,)
        self.until(lambda: heard(WAY_ODOM)[-1].twist.twist == stands, "it drives on", 1.0, *silent)
        self.assertTrue(change("{waypoints: [[1.0, 0.0], [0.0, 0.0]]}").success)
        self.until(
            lambda: heard(WAY_ODOM)[-1].twist.twist.linear.x > 0.1, "it stays", 60.0, *silent
        )
        self.graph.kill("/way/waypoint_controller")
        wait_until(lambda: commands.messages()[-1] == Twist(), lambda: "it drives on")

    @extended
    def test_random_controller_draws_by_seed_and_period_and_stops_at_its_end(self) -> None:
        """Course 001-robot-5, err-9, err-10."""
        node = Process(
            os.path.join(SCRIPTS, "random_controller"),
            ["__ns:=any", "_seed:=7", "_controller_type:=gazebo"],
        )
        self.addCleanup(node.end)
        topic = "/any/cmd_vel"
        self.clock.subscribe(topic, TwistStamped, 0.0)
        self.addCleanup(self.clock.expect, topic, 0.0)

        def gaps() -> List[float]:
            """Return the times between velocities, in the order of time."""
            stamps = [message.header.stamp.to_sec() for message in self.clock.heard(topic)]
            return [round(b - a, 1) for a, b in zip(stamps, stamps[1:])]

        def drawn() -> List[Velocity]:
            twists = [message.twist for message in self.clock.heard(topic)]
            return [Velocity(twist.linear.x, twist.angular.z) for twist in twists]

        self.until(drawn, "it says nothing", 1000.0, topic)
        self.clock.expect(topic, 5.0)
        self.until(lambda: gaps()[-3:] == [0.2] * 3, "it says no more", 10.0)
        change = rospy.ServiceProxy("/any/random_controller/change", SetParameters)
        refused = change("{linear_min: 0.3}")
        self.assertFalse(refused.success)
        self.assertIn("linear_min must be at most linear_max", refused.message)
        self.clock.expect(topic, 1.0)
        self.assertTrue(change("{timer_period_ms: 1000, seed: 8}").success)
        wanderer = Wanderer(8)
        expected = [wanderer.draw((0.1, 0.2), (-1.0, 1.0)) for _ in range(3)]
        self.until(lambda: drawn()[-3:] == expected, "it draws otherwise", 10.0)
        self.assertEqual(gaps()[-2:], [1.0] * 2)
        contact = rospy.Publisher("/any/contact", Bool, queue_size=10)
        wait_until(contact.get_num_connections, lambda: "no node subscribes to contacts")
        contact.publish(Bool(True))
        contact.publish(Bool(False))  # as soon as it turns
        self.until(
            lambda: drawn()[-2:] in ([(0.0, 1.0)] * 2, [(0.0, -1.0)] * 2), "no turn away", 10.0
        )
        self.until(lambda: drawn()[-1].linear >= 0.1, "it turns on", 10.0)
        self.assertEqual(node.interrupt(), 0)
        wait_until(lambda: drawn()[-1] == (0.0, 0.0), lambda: "it drives on")

    def test_who_hears_a_command_in_the_same_process_may_stop_the_robot(self) -> None:
        node = Node(Names.hosted("/same", "process"))
        self.addCleanup(node.close)
        commands, heard = Commands(node, "rviz"), []

        def stop(command: Twist) -> None:
            heard.append(command.linear.x)
            commands.publish(STOP)

        node.create_subscription("cmd_vel", Twist, stop)
        node.start()
        commands.publish(Velocity(0.1, 0.0))
        self.assertEqual(heard, [0.1, 0.0])
        commands.close()
        commands.publish(Velocity(0.2, 0.0))  # as a timer may that is not stopped yet
        self.assertEqual(heard, [0.1, 0.0])


if __name__ == "__main__":
    rospy.init_node("test_robot")
    rosrun("bot_controller_demo", "robot", Robots)
