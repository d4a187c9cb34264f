#!/usr/bin/env python3
"""Robots appear and disappear, and the fleet monitor reports them."""

import os
import signal

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from helpers.monitor_rig import MONITOR, SCRIPTS, MonitorRig, report, start

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class Monitors(MonitorRig):
    """A fleet and its monitor."""

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

    def test_diagnostics_are_what_ros_s_tool_shows(self) -> None:
        recorder = MessageRecorder("/diagnostics", DiagnosticArray)
        self.addCleanup(recorder.close)

        def complete(array: DiagnosticArray) -> bool:
            names = {status.name for status in array.status}
            return {"monitor", "monitor: one", "monitor: ghost"} <= names

        statuses = {status.name: status for status in recorder.wait_for(complete).status}
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


if __name__ == "__main__":
    rosrun("robot_interfaces_demo", "monitors", Monitors)
