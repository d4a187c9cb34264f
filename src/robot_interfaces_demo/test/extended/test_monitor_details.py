#!/usr/bin/env python3
"""Defects of robots, two robots with one name, a suspended monitor, simulated time."""

import rospy
from helpers.monitor_rig import MONITOR, MonitorRig, report, start
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from nodekit.testing.processes import hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from robot_custom_interfaces.msg import RobotStatus


class MonitorDetails(MonitorRig):
    """Rare faults, and each word of the report."""

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

    def test_monitor_that_hangs_does_not_hold_up_the_command(self) -> None:
        with hanging(self.monitor.popen.pid):
            command = start("fleet_report", MONITOR, "--timeout", "0.5")
            self.assertEqual(command.wait(), 2)
        self.assertIn("does not answer", command.error_lines[0])

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
        # After fifty periods of the machine's time, during which the clock is stopped.
        stands = "simulated time is stopped, so no robot becomes stale"
        self.wait_for_line("WARN: 1 robot, nothing wrong", stands, monitor="/simulated")
        self.assertEqual(monitor.logged("sim: stale"), [])

        def lost() -> bool:
            go_on()
            return bool(monitor.logged("sim: lost"))

        wait_until(lost, lambda: str(monitor.lines))
        self.assertNotIn(stands, report("/simulated").message)
        self.assertEqual(monitor.interrupt(), 0)


if __name__ == "__main__":
    rosrun("robot_interfaces_demo", "monitor_details", MonitorDetails)
