"""Messages to pages that show robots, and control of a robot by one page."""

import threading
import time
from typing import List

import genpy.dynamic
import rospy
from geometry_msgs.msg import Twist, TwistStamped
from visualization_msgs.msg import Marker, MarkerArray
from wire.client import Message
from wire.robot import Command
from wire.robots_test import RobotsTest

from nodekit.testing.waiting import TIMEOUT_S, wait_until

STATUS = "string robot_name\nuint8 mode\nfloat32[] sensor_readings\n"


def has(reply: Message, *topics: str) -> bool:
    """Return whether a message contains topics."""
    return set(topics) <= {one["topic"] for one in reply["robots"] + reply["scans"]}


def moves(commands: List[Command]) -> bool:
    """Return whether commands have no pause."""
    return bool(commands) and all(command.speed for command in commands)


class Feed(RobotsTest):
    """Messages to a page."""

    def test_is_fed_only_while_a_page_shows_robots(self) -> None:
        robot = self.robot("/feed/")
        world = rospy.Publisher("/feed/world", MarkerArray, queue_size=1, latch=True)
        self.addCleanup(world.unregister)
        world.publish(MarkerArray([Marker(type=Marker.CUBE)]))
        status_class = genpy.dynamic.generate_dynamic("not_here/RobotStatus", STATUS)
        status = rospy.Publisher(
            "/feed/status", status_class["not_here/RobotStatus"], queue_size=1, latch=True
        )
        self.addCleanup(status.unregister)
        status.publish("al", 4, [12.5])
        page = self.page()
        wait_until(lambda: page.messages("fields"), lambda: "no fields")
        self.assertEqual(robot.odometry.get_num_connections(), 0)
        for _ in range(2):  # latched messages are received again
            page.forget()
            page.send("robots", on=True)
            seen = page.wait_for("robots", lambda reply: has(reply, "/feed/odom", "/feed/scan"))
            (scan,) = (scan for scan in seen["scans"] if scan["topic"] == "/feed/scan")
            self.assertEqual(scan["ranges"], [2000] * 16)
            page.wait_for("scenery", lambda message: message["markers"])
            fleet = page.wait_for("fleet", lambda message: message["robots"])
            self.assertEqual(fleet["robots"][0]["name"], "al")
            self.assertEqual(fleet["robots"][0]["readings"], [12.5])
            page.send("robots", on=False)
            wait_until(
                lambda: robot.odometry.get_num_connections() == 0, lambda: "it still listens"
            )

    def test_message_with_wrong_fields_is_ignored(self) -> None:
        false = genpy.dynamic.generate_dynamic("nav_msgs/Odometry", "float64 data\n")
        publisher = rospy.Publisher("/false", false["nav_msgs/Odometry"], queue_size=1, latch=True)
        self.addCleanup(publisher.unregister)
        publisher.publish(1.0)
        robot = self.robot("/honest/")
        page = self.page()
        page.send("robots", on=True)
        wait_until(publisher.get_num_connections, lambda: "no subscriber")
        robot.x = 4.0
        page.wait_for("robots", lambda reply: any(one["x"] == 4.0 for one in reply["robots"]))

    def test_a_goal_is_sent(self) -> None:
        robot = self.robot("/aimed/")
        page = self.page()
        page.send("robots", on=True)
        page.wait_for("targets", lambda reply: "/aimed/goal" in reply["goals"])
        goal = {"topic": "/aimed/goal", "frame": "odom", "x": 1.5, "y": -2.0, "heading": 3.0}
        page.send("goal", **goal)
        page.wait_for("sent")
        (message,) = wait_until(lambda: robot.goals[:], lambda: "no goal has come")
        pose = message.pose
        self.assertEqual((message.header.frame_id, pose.position.x), ("odom", 1.5))
        self.assertAlmostEqual(pose.orientation.z, 0.9975, delta=1e-4)
        for topic, why in (
            ("/missing", "no subscriber of"),
            ("/aimed/cmd_vel", "takes a PoseSt"),
        ):
            page.forget()
            page.send("goal", **{**goal, "topic": topic})
            self.assertIn(why, page.wait_for("error")["text"])


class DeadMan(RobotsTest):
    """A robot without commands stops: one zero, then silence."""

    def test_another_page_takes_the_wheel(self) -> None:
        robot = self.robot("/two/")
        first = self.driver("/two/cmd_vel")
        self.drive(first)
        second = self.driver("/two/cmd_vel")
        first.wait_for("steering", lambda reply: reply["topic"] == "")
        first.wait_for("error", lambda reply: "another page" in reply["text"])
        self.stopped(robot)
        first.forget()
        self.drive(first)
        first.wait_for("error", lambda reply: "take the wheel first" in reply["text"])
        before = len(robot.commands)
        self.drive(second)
        wait_until(lambda: len(robot.commands) > before, lambda: "it does not drive")
        self.stopped(robot)

    def test_last_requested_wheel_is_taken(self) -> None:
        topics = ["/quick/cmd_vel", "/other/cmd_vel"]
        for space in ("/quick/", "/other/"):
            self.robot(space)
        for second in topics:  # a double click, and another before the reply
            page = self.page()
            page.send("robots", on=True)
            page.wait_for("targets", lambda reply: set(topics) <= set(reply["commands"]))
            for topic in (topics[0], second):
                page.send("steer", topic=topic)
            page.wait_for("steering", lambda reply: reply["topic"] == second)
            page.close()

    def test_late_command_is_ignored_and_reported(self) -> None:
        robot = self.robot("/late/")
        page = self.driver("/late/cmd_vel")
        self.drive(page)
        self.stopped(robot)
        page.forget()
        del robot.commands[:]
        page.send("drive", speed=0.2, turn=0.5, sent=time.monotonic() - 1.0)
        self.assertIn("too late", page.wait_for("error")["text"])
        self.assertLessEqual({reply.speed for reply in robot.commands}, {0.0})

    def test_commands_have_the_current_type_of_the_subscriber(self) -> None:
        # The master still reports the first type.
        earlier = rospy.Subscriber("/changed/cmd_vel", Twist, lambda _: None)
        earlier.unregister()
        self.robot("/changed/", TwistStamped)
        page = self.driver("/changed/cmd_vel")
        self.assertEqual(page.messages("steering")[-1]["datatype"], "geometry_msgs/TwistStamped")

    def test_the_scope_ends(self) -> None:
        robot = self.robot("/ended/")
        page = self.driver("/ended/cmd_vel")

        def hold() -> None:  # hold the key until the scope has ended
            while not page.is_closed:
                page.send("drive", speed=0.2, turn=0.5, sent=time.monotonic())
                time.sleep(0.01)

        holding = threading.Thread(target=hold, daemon=True)
        holding.start()
        wait_until(lambda: moves(robot.commands), lambda: "it does not drive")
        self.addCleanup(self.scope.wait_until_served)
        self.addCleanup(self.scope.start)
        self.scope.stop()
        holding.join(TIMEOUT_S)
        commands = self.stopped(robot)
        self.assertEqual([command.speed for command in commands[-2:]], [0.2, 0.0])
