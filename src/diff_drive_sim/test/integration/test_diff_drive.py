#!/usr/bin/env python3
"""The robots on the wire, while the test moves the clock."""

import math
import unittest
from typing import Any, Dict, List, Tuple

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from diff_drive_sim.simulation.kinematics import Pose, wrapped
from nodekit.testing.changing import change
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: Longer than the period of 30 Hz, so that each robot publishes at each step of the clock.
STEP = 0.04
ROBOTS = ["", "/lab", "/robot1", "/robot2", "/robot3"]


def pose(message: Odometry) -> Pose:
    """Return the pose in a message."""
    where = message.pose.pose
    theta = 2.0 * math.atan2(where.orientation.z, where.orientation.w)
    return Pose(where.position.x, where.position.y, wrapped(theta))


def node_of(robot: str) -> str:
    """Return the name of the node that has a robot, by the robot's namespace."""
    return "/diff_drive_fleet" if "robot" in robot else robot + "/diff_drive"


class DiffDrive(unittest.TestCase):
    """All robots are at their initial poses before each test."""

    graph: Graph
    clock: rospy.Publisher
    log: MessageRecorder
    odometry: Dict[str, MessageRecorder]
    commands: Dict[Tuple[str, type], rospy.Publisher] = {}
    now = 1000.0

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_diff_drive")
        cls.graph = Graph()
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.log = MessageRecorder("/rosout", Log)
        cls.odometry = {robot: MessageRecorder(robot + "/odom", Odometry) for robot in ROBOTS}
        robots = [node_of(robot) for robot in ROBOTS]
        cls.graph.wait_until_heard(rospy.get_name(), "/clock", *robots)
        for robot in ROBOTS:
            cls.wait_for_recorder(robot, "/odom")
            cls.wait_for_recorder(robot, "/rosout")

    @classmethod
    def wait_for_recorder(cls, robot: str, topic: str) -> None:
        """Wait until a subscriber of this test is connected.

        :param robot: its namespace
        :param topic: one of the robot's, or a global one
        """
        name = topic if topic in ("/tf", "/rosout") else robot + topic
        cls.graph.wait_until_heard(node_of(robot), name, rospy.get_name())

    def setUp(self) -> None:
        for robot in ROBOTS:
            self.reset(robot)
        self.advance(STEP)
        self.log.clear()

    def reset(self, robot: str) -> str:
        """Put a robot back to its initial pose, and return its answer."""
        name = robot + "/diff_drive/reset"
        rospy.wait_for_service(name, TIMEOUT_S)
        return str(rospy.ServiceProxy(name, Trigger)().message)

    def advance(self, seconds: float) -> None:
        """Let the clock jump, and wait until each robot has published its pose."""
        DiffDrive.now += seconds
        stamp = rospy.Time.from_sec(self.now)
        for recorder in self.odometry.values():
            recorder.clear()
        self.clock.publish(Clock(stamp))
        for recorder in self.odometry.values():
            recorder.wait_for(lambda message: message.header.stamp == stamp)

    def at(self, robot: str = "") -> Pose:
        """Return a robot's estimated pose."""
        return pose(self.odometry[robot].messages()[-1])

    def send(self, linear: float, angular: float, robot: str = "", kind: type = Twist) -> None:
        """Command a robot once."""
        key = (robot, kind)
        if key not in self.commands:
            self.commands[key] = rospy.Publisher(robot + "/cmd_vel", kind, queue_size=10)
        publisher = self.commands[key]
        wait_until(publisher.get_num_connections, lambda: f"{robot}/cmd_vel is not heard")
        message: Any = kind()
        twist = getattr(message, "twist", message)
        twist.linear.x, twist.angular.z = linear, angular
        publisher.publish(message)

    def hush(self, robot: str, kind: type) -> None:
        """Stop publishing commands of a type: a process has one type per topic."""
        if (robot, kind) in self.commands:
            self.commands.pop((robot, kind)).unregister()

    def drive(self, *command: Any) -> Pose:
        """Command a robot once, and return its pose when it moves.

        The arrival time of the command is random; the result is not.
        """
        robot = command[2] if len(command) > 2 else ""
        start = self.at(robot)
        self.send(*command)
        wait_until(
            lambda: (self.advance(STEP), self.at(robot) != start)[1],
            lambda: f"{robot} stays at {start}",
        )
        return self.at(robot)

    def assert_at(self, expected: Pose, robot: str = "", delta: float = 1e-7) -> None:
        found = self.at(robot)
        self.assertLess(math.hypot(found.x - expected.x, found.y - expected.y), delta, found)
        self.assertLess(abs(wrapped(found.theta - expected.theta)), delta, found)

    def test_names_and_types_are_those_of_turtlebot3_fake(self) -> None:
        """Types of the commands go by controller_type. Course 001-robot-2."""
        types = self.graph.topics()
        self.assertEqual(types["/tf"], "tf2_msgs/TFMessage")
        for robot in ROBOTS:
            stamped = "Stamped" if robot == "/lab" else ""
            expected = {
                "cmd_vel": "geometry_msgs/Twist" + stamped,
                "odom": "nav_msgs/Odometry",
                "joint_states": "sensor_msgs/JointState",
                "ground_truth": "nav_msgs/Odometry",
                "scan": "sensor_msgs/LaserScan",
                "contact": "std_msgs/Bool",
                "world": "visualization_msgs/MarkerArray",
            }
            self.assertEqual({name: types[f"{robot}/{name}"] for name in expected}, expected)

    def test_frames_and_the_order_of_the_wheels_are_too(self) -> None:
        """And angular.z is counter-clockwise. Course 001-robot-3."""
        transforms, joints = (
            MessageRecorder("/tf", TFMessage),
            MessageRecorder("/joint_states", JointState),
        )
        self.wait_for_recorder("", "/joint_states")
        for robot in ROBOTS:
            self.wait_for_recorder(robot, "/tf")
        self.drive(0.0, 1.0)
        message = self.odometry[""].messages()[-1]
        self.assertEqual(message.header.frame_id, "odom")
        self.assertEqual(message.child_frame_id, "base_footprint")
        self.assertAlmostEqual(message.twist.twist.angular.z, 1.0)
        wheels = joints.wait_for(lambda heard: heard.header.stamp == message.header.stamp)
        self.assertEqual(wheels.header.frame_id, "base_footprint")
        self.assertEqual(wheels.name, ["wheel_left_joint", "wheel_right_joint"])
        self.assertEqual(wheels.effort, (0.0, 0.0))
        # Counter-clockwise, the right wheel rolls forward.
        speed = 1.0 * 0.08 / 0.033
        self.assertAlmostEqual(wheels.velocity[0], -speed)
        self.assertAlmostEqual(wheels.velocity[1], speed)
        self.assertAlmostEqual(wheels.position[1], self.at().theta * 0.08 / 0.033)
        heard = transforms.wait_for(
            lambda heard: (
                heard.transforms[0].child_frame_id == "base_footprint"
                and heard.transforms[0].header.stamp == message.header.stamp
            )
        )
        base, laser = heard.transforms
        self.assertEqual(base.header.frame_id, "odom")
        self.assertEqual(base.transform.rotation, message.pose.pose.orientation)
        self.assertEqual(
            (laser.header.frame_id, laser.child_frame_id), ("base_footprint", "base_scan")
        )
        self.assertEqual(laser.transform.translation.x, -0.032)
        transforms.wait_for(lambda heard: heard.transforms[0].header.frame_id == "lab/odom")
        transforms.wait_for(
            lambda heard: heard.transforms[0].child_frame_id == "robot3/base_footprint"
        )
        for recorder in (transforms, joints):
            recorder.close()

    def test_a_command_acts_for_a_second_on_the_exact_arc(self) -> None:
        """The pose is on odom. Course 001-robot-4, err-1."""
        self.drive(0.15, 1.2)
        self.advance(0.3)
        self.assertAlmostEqual(self.odometry[""].messages()[-1].twist.twist.linear.x, 0.15)
        self.advance(0.5)
        self.advance(0.5)
        self.assert_at(Pose().moved(0.15, 1.2))
        self.assertEqual(self.odometry[""].messages()[-1].twist.twist.linear.x, 0.0)

    def test_limits_of_the_model_hold(self) -> None:
        self.drive(10.0, 0.0)
        self.drive(10.0, 0.0, "/lab", TwistStamped)
        speeds = [self.odometry[name].messages()[-1].twist.twist.linear.x for name in ("", "/lab")]
        self.assertAlmostEqual(speeds[0], 0.22)
        self.assertAlmostEqual(speeds[1], 0.26)
        change("/diff_drive", max_linear_velocity=0.1)
        self.advance(STEP)
        self.assertAlmostEqual(self.odometry[""].messages()[-1].twist.twist.linear.x, 0.1)
        change("/diff_drive", max_linear_velocity=0.22)

    def test_a_clock_that_jumps_an_hour_ahead_moves_it_no_longer_than_the_command_acts(
        self,
    ) -> None:
        self.drive(0.2, 0.0)
        self.advance(3600.0)
        self.assert_at(Pose(0.2, 0.0, 0.0))

    def test_a_clock_that_is_set_back_moves_nothing_and_time_goes_on_from_there(self) -> None:
        before = self.drive(0.2, 0.5)
        self.advance(-500.0)
        self.assertEqual(self.at(), before)
        self.advance(0.3)
        self.assertNotEqual(self.at(), before)
        self.advance(3600.0)
        self.assert_at(Pose().moved(0.2, 0.5))

    def test_reset_puts_it_back_at_rest(self) -> None:
        self.drive(0.2, 0.5)
        self.assertEqual(self.reset(""), "at x 0 m, y 0 m, heading 0 rad")
        self.advance(0.5)
        self.assertEqual(self.at(), Pose())
        self.assertEqual(self.reset("/lab"), "at x 0 m, y 1.5 m, heading 0.5 rad")
        self.assert_at(Pose(0.0, 1.5, 0.5), "/lab")

    def test_what_is_not_finite_is_ignored_with_a_warning(self) -> None:
        self.send(math.nan, 0.0)
        line = self.log.wait_for(lambda line: "must be finite" in line.msg)
        self.assertEqual(line.level, Log.WARN)
        self.assertEqual(
            line.msg, "/cmd_vel: ignored a command of nan m/s and 0.0 rad/s: must be finite"
        )
        for _ in range(3):
            self.send(math.inf, 0.0)
        self.advance(1.0)
        self.assertEqual(self.at(), Pose())
        self.drive(0.1, 0.0)  # by which time those of before have come, too
        told = [line for line in self.log.messages() if "must be finite" in line.msg]
        self.assertEqual(len(told), 1)

    def test_transforms_are_left_to_others_where_that_is_wanted(self) -> None:
        transforms = MessageRecorder("/tf", TFMessage)
        self.addCleanup(transforms.close)
        for robot in ROBOTS:
            self.wait_for_recorder(robot, "/tf")
        self.addCleanup(change, "/diff_drive", publish_tf=True)
        change("/diff_drive", publish_tf=False)
        transforms.clear()
        for _ in range(2):
            self.advance(STEP)
        transforms.wait_for(lambda heard: heard.transforms[0].header.frame_id == "robot3/odom")
        frames = {heard.transforms[0].header.frame_id for heard in transforms.messages()}
        self.assertNotIn("odom", frames)

    def test_who_sends_the_other_type_is_told_and_moves_nothing(self) -> None:
        for robot, sent, expected in (("", TwistStamped, Twist), ("/lab", Twist, TwistStamped)):
            start = self.at(robot)
            self.hush(robot, expected)
            self.send(0.2, 0.0, robot, sent)
            line = self.log.wait_for(lambda line: "ignoring the messages" in line.msg)
            self.assertEqual(line.level, Log.WARN)
            self.assertEqual(
                line.msg,
                f"{robot}/cmd_vel: ignoring the messages of /test_diff_drive: they are "
                f"{sent._type}, not {expected._type}; "
                "controller_type must be the same in both nodes",
            )
            self.advance(1.0)
            self.assertEqual(self.at(robot), start)
            self.hush(robot, sent)
            self.log.clear()

    def test_the_type_can_be_changed_while_it_runs(self) -> None:
        change("/diff_drive", controller_type="gazebo")
        self.hush("", Twist)
        wait_until(
            lambda: (
                self.graph.topics()["/cmd_vel"] == TwistStamped._type
                or self.send(0.0, 0.0, "", TwistStamped)
            ),
            lambda: "the type stays",
        )
        self.drive(0.2, 0.0, "", TwistStamped)
        self.advance(2.0)  # the command ends: what moves it then is the next one, of the other type
        self.hush("", TwistStamped)
        change("/diff_drive", controller_type="rviz")
        self.drive(0.2, 0.0)

    def test_odometry_with_noise_says_how_far_it_may_be_off(self) -> None:
        truth = MessageRecorder("/lab/ground_truth", Odometry)
        self.wait_for_recorder("/lab", "/ground_truth")
        self.drive(0.2, 0.3, "/lab", TwistStamped)
        self.advance(2.0)
        message = self.odometry["/lab"].messages()[-1]
        true = truth.wait_for(lambda heard: heard.header.stamp == message.header.stamp)
        truth.close()
        exact = Pose(0.0, 1.5, 0.5).moved(0.2, 0.3)
        for found, wanted in zip(pose(true), exact):
            self.assertAlmostEqual(found, wanted)
        off = [found - wanted for found, wanted in zip(self.at("/lab"), exact)]
        variances = [message.pose.covariance[place] for place in (0, 7, 35)]
        for error, variance in zip(off, variances):
            self.assertNotEqual(error, 0.0)
            self.assertLess(abs(error), 5.0 * math.sqrt(variance))
        self.assertEqual(message.header.frame_id, "lab/odom")
        self.assertEqual(true.header.frame_id, "lab/odom")
        matrix = message.pose.covariance
        self.assertEqual([matrix[5], matrix[11], matrix[1]], [matrix[30], matrix[31], matrix[6]])
        self.assertNotEqual(matrix[5], 0.0)
        # Variances of quantities that wheels do not measure, and of a robot without noise.
        self.assertEqual([matrix[14], matrix[21], matrix[28]], [1e6, 1e6, 1e6])
        self.assertEqual(self.odometry[""].messages()[-1].pose.covariance[0], 1e-9)

    def test_robots_in_other_namespaces_are_not_moved(self) -> None:
        before = {robot: self.at(robot) for robot in ROBOTS}
        self.drive(0.2, 0.0, "/robot2")
        for robot in ROBOTS:
            self.assertEqual(self.at(robot) == before[robot], robot != "/robot2", robot)

    def test_a_fleet_stands_in_a_square_with_frames_of_its_own(self) -> None:
        self.assertEqual(self.at("/robot1"), Pose(0.0, 0.0, 0.0))
        self.assertEqual(self.at("/robot2"), Pose(1.0, 0.0, 0.0))
        self.assertEqual(self.at("/robot3"), Pose(0.0, 1.0, 0.0))
        message = self.odometry["/robot2"].messages()[-1]
        self.assertEqual(message.header.frame_id, "robot2/odom")
        self.assertEqual(self.graph.parameter("/robot2/diff_drive/frame_prefix"), "robot2/")
        self.assertEqual(self.graph.parameter("/robot2/diff_drive/initial_x"), 1.0)
        # Each has its own noise.
        seeds = [self.graph.parameter(f"/robot{number}/diff_drive/seed") for number in (1, 2, 3)]
        self.assertEqual(seeds, [0, 1, 2])

    def test_the_laser_of_a_robot_of_a_fleet_is_in_its_own_tree(self) -> None:
        robot = "/robot2"
        scans, transforms = (
            MessageRecorder(robot + "/scan", LaserScan),
            MessageRecorder("/tf", TFMessage),
        )
        for recorder, topic in ((scans, "/scan"), (transforms, "/tf")):
            self.addCleanup(recorder.close)
            self.wait_for_recorder(robot, topic)
        self.addCleanup(change, robot + "/diff_drive", scan_rate=0.0)
        change(robot + "/diff_drive", scan_rate=10.0)
        self.advance(0.2)
        scan = scans.wait_for(lambda heard: True)
        self.assertEqual(scan.header.frame_id, "robot2/base_scan")
        base = "robot2/base_footprint"
        told = transforms.wait_for(lambda heard: heard.transforms[-1].header.frame_id == base)
        frames = [each.child_frame_id for each in told.transforms]
        self.assertEqual(frames, [base, "robot2/base_scan"])
        self.assertEqual(told.transforms[0].header.frame_id, "robot2/odom")

    def test_who_comes_late_is_told_that_a_robot_touches_nothing(self) -> None:
        contact = MessageRecorder("/robot3/contact", Bool)
        self.addCleanup(contact.close)
        self.assertFalse(contact.wait_for(lambda heard: True).data)

    def test_a_wall_stops_it_where_it_touches(self) -> None:
        contact = MessageRecorder("/contact", Bool)
        self.wait_for_recorder("", "/contact")
        change("/diff_drive", command_timeout=0.0)
        self.drive(0.2, 0.0)
        self.advance(60.0)
        self.assert_at(Pose(3.0 - 0.105, 0.0, 0.0), delta=1e-6)
        contact.wait_for(lambda heard: heard.data)
        contact.clear()
        self.send(-0.2, 0.0)  # pressed against the wall it may move by a rounding before this comes
        wait_until(
            lambda: (self.advance(STEP), not all(heard.data for heard in contact.messages()))[1],
            lambda: "it still touches the wall",
        )
        contact.close()
        change("/diff_drive", command_timeout=1.0)
        self.advance(1.5)
        self.assertEqual(self.odometry[""].messages()[-1].twist.twist, Twist(), "it drives on")

    def test_the_laser_sees_the_walls_where_they_are(self) -> None:
        scans = MessageRecorder("/scan", LaserScan)
        self.wait_for_recorder("", "/scan")
        self.advance(0.2)
        scan = scans.wait_for(lambda heard: heard.header.stamp.to_sec() >= self.now - 1e-6)
        scans.close()
        self.assertEqual(scan.header.frame_id, "base_scan")
        self.assertEqual(len(scan.ranges), 360)
        # From 0.032 m behind the middle of a square of 6 m.
        self.assertAlmostEqual(scan.ranges[0], 3.032, places=6)
        self.assertAlmostEqual(scan.ranges[90], 3.0, places=6)
        self.assertAlmostEqual(scan.ranges[180], 2.968, places=6)
        self.assertTrue(math.isinf(scan.ranges[180 + 45]))  # the corner is beyond 3.5 m
        self.assertLess(scan.ranges[45], 2.3)  # a box

    def test_what_the_laser_is_like_can_be_changed_while_it_scans(self) -> None:
        scans = MessageRecorder("/scan", LaserScan)
        self.wait_for_recorder("", "/scan")
        self.addCleanup(scans.close)
        self.addCleanup(change, "/diff_drive", scan_rays=360, scan_range=3.5, laser_x=-0.032)
        change("/diff_drive", scan_rays=4, scan_range=2.9, laser_x=0.5)
        self.advance(0.2)
        scan = scans.wait_for(lambda heard: len(heard.ranges) == 4)
        self.assertAlmostEqual(scan.range_max, 2.9, places=6)
        self.assertAlmostEqual(scan.ranges[0], 2.5, places=6)
        self.assertTrue(math.isinf(scan.ranges[2]))  # that wall is 3.5 m away

    def test_whoever_comes_late_gets_the_world_and_each_change_of_it(self) -> None:
        worlds = MessageRecorder("/world", MarkerArray)
        world = worlds.wait_for(lambda heard: True)
        self.assertEqual(world.markers[0].action, Marker.DELETEALL)
        self.assertEqual({marker.header.frame_id for marker in world.markers}, {"odom"})
        kinds: List[Any] = [(marker.ns, marker.type) for marker in world.markers[1:]]
        self.assertEqual(kinds, [("walls", Marker.LINE_LIST)] + 3 * [("boxes", Marker.CUBE)])
        self.assertEqual(len(world.markers[1].points), 8)
        boxes = rospy.get_param("/diff_drive/boxes")
        rospy.set_param("/diff_drive/boxes", boxes[:1])
        worlds.wait_for(lambda heard: len(heard.markers) == 3)
        worlds.clear()
        rospy.set_param("/diff_drive/boxes", boxes)
        worlds.wait_for(lambda heard: len(heard.markers) == 5)
        worlds.close()


if __name__ == "__main__":
    rosrun("diff_drive_sim", "diff_drive", DiffDrive)
