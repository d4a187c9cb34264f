#!/usr/bin/env python3
"""Robots come and go, and the monitor of the fleet notices."""

import os
import signal
import unittest
from typing import Dict, List

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerResponse

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from robot_custom_interfaces.msg import RobotStatus

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
MONITOR = "/monitor"
#: Robots tell how they are five times a second.
TIMES = ("_longest_period:=0.5", "_lost_after:=5")
#: The nodes that all tests share.
NODES: Dict[str, List[str]] = {
    "monitor": ["fleet_monitor", "_rate:=20", *TIMES, "_expected:=[one, ghost]"],
    "one": ["robot_monitor", "_robot_name:=one", "_period:=0.2"],
    "two": ["robot_monitor", "_robot_name:=two", "_period:=0.2"],
    "demo": ["robot_status_demo", "__ns:=in_one"],
}


def start(script: str, *arguments: str) -> Process:
    """Start a node or a command."""
    return Process(os.path.join(SCRIPTS, script), arguments)


def report(monitor: str = MONITOR) -> TriggerResponse:
    """Return how all are."""
    return rospy.ServiceProxy(f"{monitor}/report", Trigger)()


class Monitors(unittest.TestCase):
    """A fleet and its monitor."""

    nodes: Dict[str, Process] = {}

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_monitors")
        cls.nodes = {
            name: start(script, f"__name:={name}", *arguments)
            for name, (script, *arguments) in NODES.items()
        }
        for monitor in (MONITOR, "/in_one/fleet_monitor"):
            rospy.wait_for_service(f"{monitor}/report")

    @classmethod
    def tearDownClass(cls) -> None:
        for process in cls.nodes.values():
            process.end()

    @property
    def monitor(self) -> Process:
        """The process of the monitor."""
        return self.nodes["monitor"]

    def robot(self, name: str, *arguments: str) -> Process:
        process = start("robot_monitor", f"__name:={name}", *arguments)
        self.addCleanup(process.end)
        return process

    def wait_for_line(self, *words: str, monitor: str = MONITOR) -> None:
        """Wait for a line of the report that has these words."""

        def found() -> List[str]:
            lines = report(monitor).message.splitlines()
            return [line for line in lines if all(word in line for word in words)]

        wait_until(found, lambda: f"{words} in {report(monitor).message}")

    def wait_for_count(self, count: int, *words: str) -> None:
        """Wait until the monitor has logged so many lines with these words."""
        wait_until(
            lambda: len(self.monitor.logged(*words)) >= count, lambda: str(self.monitor.lines[-20:])
        )

    def test_robot_that_dies_is_stale_then_lost_then_back(self) -> None:
        """Course 001-if-2, 001-if-3."""
        robot = self.robot("three", "_robot_name:=three", "_period:=0.2")
        self.wait_for_line("three", "OK", "present")
        robot.popen.send_signal(signal.SIGKILL)
        self.monitor.wait_for_log("[WARN]", "three: stale, no message for")
        self.monitor.wait_for_log("[ERROR]", "three: lost, no message for")
        self.wait_for_line("three", "ERROR", "lost")
        self.robot("again", "_robot_name:=three", "_period:=0.2")
        self.monitor.wait_for_log("[WARN]", "three: returning")
        self.wait_for_line("three", "OK", "present")

    def test_expected_robot_is_told_of_and_the_list_is_live(self) -> None:
        self.monitor.wait_for_log("[ERROR]", "ghost: never seen, no message for")
        self.wait_for_line("ghost", "ERROR", "never seen")
        self.assertFalse(report().success)
        rospy.set_param(f"{MONITOR}/expected", ["one"])
        wait_until(lambda: "ghost" not in report().message, lambda: report().message)
        rospy.set_param(f"{MONITOR}/expected", ["one", "ghost"])
        self.wait_for_line("ghost", "never seen")

    def test_two_publishers_under_one_name_are_an_error(self) -> None:
        self.wait_for_line("two", "OK", "present")
        rival = self.robot("rival", "_robot_name:=two", "_period:=0.1")
        text = "two: several nodes publish under this name: /rival, /two"
        self.monitor.wait_for_log("[ERROR]", text)
        self.wait_for_line("two", "ERROR", "several nodes publish under this name")
        self.assertEqual(rival.interrupt(), 0)
        self.monitor.wait_for_log("two: one node publishes under this name again")
        self.wait_for_line("two", "OK", "present")

    def test_defects_are_told_once_and_shown_each_time(self) -> None:
        for fault, text in (
            ("short", "one: readings are missing: 1 of 3 received"),
            ("not_finite", "one: a reading is not finite: temperature nan"),
            ("unknown_mode", "one: unknown mode 99"),
        ):
            for _ in range(2):
                rospy.set_param("/one/fault", fault)
                self.wait_for_line("one", "WARN", text.partition(": ")[2])
                rospy.set_param("/one/fault", "none")
                self.wait_for_line("one", "OK")
            self.wait_for_count(1, text)
        for fault in ("low_battery", "low_battery"):
            rospy.set_param("/one/fault", fault)
            self.wait_for_line("one", "WARN", "battery is low: 10.50 V")
            rospy.set_param("/one/fault", "none")
            self.wait_for_line("one", "OK")
        self.wait_for_count(2, "one: cleared: battery is low")
        for text in ("missing", "not finite", "unknown mode"):
            self.assertEqual(len(self.monitor.logged("one: ", text)), 1, text)

    def test_diagnostics_are_what_ros_s_tool_shows(self) -> None:
        ear = MessageRecorder("/diagnostics", DiagnosticArray)
        self.addCleanup(ear.close)

        def complete(array: DiagnosticArray) -> bool:
            names = {status.name for status in array.status}
            return {"monitor", "monitor: one", "monitor: ghost"} <= names

        statuses = {status.name: status for status in ear.wait_for(complete).status}
        self.assertEqual(statuses["monitor"].level, 2)
        one = statuses["monitor: one"]
        self.assertEqual(one.hardware_id, "one")
        values = {pair.key: pair.value for pair in one.values}
        self.assertEqual(values["publisher"], "/one")
        self.assertTrue(values["battery"].endswith(" V"), values)
        tool = "from rosdiagnostic.rosdiagnostic import rosdiagnosticmain as main; main()"
        arguments = ["--topic", "/diagnostics", "--filter", "monitor: ", "--nocolor", "-d"]

        def shown() -> str:
            process = Process("-c", [tool, *arguments])
            self.assertEqual(process.wait(), 0, process.error_lines)
            return "\n".join(process.lines)

        # It shows one message, which may be of the other monitor.
        wait_until(lambda: "[ ERROR ] monitor: ghost - never seen" in shown(), shown)

    def test_command_has_a_status_for_scripts(self) -> None:
        self.wait_for_line("ghost", "never seen")
        wrong, well = start("fleet_report", MONITOR), start("fleet_report", "in_one/fleet_monitor")
        missing = start("fleet_report", "/missing")
        nowhere = Process(
            os.path.join(SCRIPTS, "fleet_report"), [], {"ROS_MASTER_URI": "http://localhost:1/"}
        )
        private = start("fleet_report", "~monitor")
        self.assertEqual(private.wait(), 2)
        self.assertIn("'~monitor': must not be private", private.error_lines[-1])
        self.assertEqual(wrong.wait(), 1)
        self.assertTrue(wrong.lines[0].startswith("robot"), wrong.lines)
        self.assertTrue(wrong.lines[-1].startswith("ERROR: "), wrong.lines)
        self.assertEqual(well.wait(), 0, well.lines + well.error_lines)
        self.assertEqual(well.lines[-1], "OK: 1 robot, nothing wrong")
        self.assertEqual(missing.wait(), 2)
        self.assertIn("there is no fleet_monitor /missing; there is ", missing.error_lines[0])
        self.assertEqual(nowhere.wait(), 2)
        self.assertIn("fleet_report: no master at ", nowhere.error_lines[0])

    def test_monitor_that_hangs_does_not_hold_up_the_command(self) -> None:
        with hanging(self.monitor.popen.pid):
            command = start("fleet_report", MONITOR, "--timeout", "0.5")
            self.assertEqual(command.wait(), 2)
        self.assertIn("does not answer", command.error_lines[0])

    def test_both_in_one_process(self) -> None:
        """Course 001-if-4."""
        demo = self.nodes["demo"]
        demo.wait_for_log("robot_01: idle, 12.4")
        demo.wait_for_log("robot_01: present")
        self.wait_for_line("robot_01", "OK", monitor="/in_one/fleet_monitor")

    def test_report_is_no_success_where_there_is_a_warning_alone(self) -> None:
        robot, monitor = "/in_one/robot_monitor", "/in_one/fleet_monitor"
        rospy.set_param(f"{robot}/period", 0.2)
        rospy.set_param(f"{robot}/fault", "low_battery")
        self.wait_for_line("WARN: 1 robot, 1 wrong: robot_01", monitor=monitor)
        self.assertFalse(report(monitor).success)
        rospy.set_param(f"{robot}/fault", "none")
        self.wait_for_line("OK: 1 robot, nothing wrong", monitor=monitor)
        self.assertTrue(report(monitor).success)

    def test_launch_file_starts_both_with_the_file_s_parameters(self) -> None:
        name = "007"  # which is text
        arguments = f"__ns:=launched robot_name:={name} period:=0.1 fault:=hot"
        with launched(f"robot_interfaces_demo robot_status_demo.launch {arguments}"):
            rospy.wait_for_service("/launched/fleet_monitor/report")
            self.wait_for_line(name, "too hot: 55.00", monitor="/launched/fleet_monitor")
            self.wait_for_line("WARN: 1 robot, ", monitor="/launched/fleet_monitor")
            expected = {"stale_after": 3.0, "expected": [name]}
            Graph().wait_for_parameters("/launched/fleet_monitor", expected)

    def test_paused_simulation_makes_nobody_lost(self) -> None:
        rospy.set_param("/use_sim_time", True)
        self.addCleanup(rospy.delete_param, "/use_sim_time")
        monitor = start(
            "fleet_monitor",
            "__name:=simulated",
            "robot_status:=simulated_status",
            "_period:=0.1",
            "_rate:=20",
        )
        self.addCleanup(monitor.end)
        clock = rospy.Publisher("/clock", Clock, queue_size=100)
        robot = rospy.Publisher("/simulated_status", RobotStatus, queue_size=100)
        rospy.wait_for_service("/simulated/report")
        for publisher in (clock, robot):
            wait_until(publisher.get_num_connections, lambda: "not connected")
        times = iter(range(1000, 100000))

        def go_on() -> None:
            clock.publish(rospy.Time(0.1 * next(times)))

        def heard() -> bool:
            go_on()
            robot.publish(RobotStatus(Header(), "sim", 0, [12.0, 25.0, 1.0]))
            return "sim: present" in str(monitor.lines)

        wait_until(heard, lambda: str(monitor.lines))
        self.assertIn("OK: 1 robot", report("/simulated").message)
        # After fifty periods of the machine's time, in which the clock stands still.
        stands = "simulated time stands still, so no robot becomes stale"
        self.wait_for_line("WARN: 1 robot, nothing wrong", stands, monitor="/simulated")
        self.assertEqual(monitor.logged("sim: stale"), [])

        def lost() -> bool:
            go_on()
            return bool(monitor.logged("sim: lost"))

        wait_until(lost, lambda: str(monitor.lines))
        self.assertNotIn(stands, report("/simulated").message)
        self.assertEqual(monitor.interrupt(), 0)


if __name__ == "__main__":
    rosrun("robot_interfaces_demo", "monitors", Monitors)
