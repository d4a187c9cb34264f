"""Fleet monitor node, for any number of robots."""

import time
from typing import List

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from nodekit import Node, run
from robot_custom_interfaces.msg import RobotStatus
from robot_interfaces_demo.diagnostics import as_message
from robot_interfaces_demo.monitoring.awake_clock import AwakeClock
from robot_interfaces_demo.monitoring.fleet import Fleet, as_table
from robot_interfaces_demo.monitoring.problems import Level
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters

#: Rate of checks for silent robots [Hz].
CHECK_HZ = 5.0
_LOGS = {Level.OK: rospy.loginfo, Level.WARN: rospy.logwarn, Level.ERROR: rospy.logerr}


class FleetMonitor:
    """Discovers robots by the names in their messages, and reports missing and faulty ones.

    Times are arrival times, by the machine's clock or, with /use_sim_time set, by ``/clock``: while
    that is stopped, no robot becomes stale, and the diagnostics say so.

    :ROS Subscribers:
        - ``robot_status`` (robot_custom_interfaces/RobotStatus)

    :ROS Publishers:
        - ``/diagnostics`` (diagnostic_msgs/DiagnosticArray): the fleet, and each robot

    :ROS Services:
        - ``~report`` (std_srvs/Trigger): the same as a table; success if all is well

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.FleetMonitorParameters`
    """

    def __init__(self, node: Node) -> None:
        self._name = node.name
        self._parameters = node.declare_parameters(
            FleetMonitorParameters, on_change=self._on_change
        )
        self._ros_time = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        self._clock = AwakeClock(1.0 / CHECK_HZ)
        self._fleet = Fleet(self._parameters.values, self._now())
        self._diagnostics = node.create_publisher("/diagnostics", DiagnosticArray)
        node.create_batch_subscription("robot_status", RobotStatus, self.on_status)
        node.create_service("~report", Trigger, self.report)
        # By the machine's clock, because a stopped /clock has to be reported, too.
        node.create_timer(CHECK_HZ, self.check_ages, steady=True)
        node.create_timer(lambda: self._parameters.values.rate, self.publish_report, steady=True)

    def _now(self) -> float:
        return self._clock.read(self._ros_time(), time.monotonic())

    def _on_change(self, new: FleetMonitorParameters, old: FleetMonitorParameters) -> None:
        self._fleet.set(new, self._now())

    def on_status(self, messages: List[RobotStatus]) -> None:
        """Record received messages."""
        now = self._now()
        for message in messages:
            publisher = message._connection_header.get("callerid", "")
            readings = message.sensor_readings
            self._fleet.add_message(message.robot_name, publisher, message.mode, readings, now)

    def check_ages(self, elapsed: float) -> None:
        """Check for silent robots."""
        self._fleet.check_ages(self._now())
        self._fleet.still_s = self._clock.still_s

    def publish_report(self, elapsed: float) -> None:
        """Log changes, and publish diagnostics."""
        for level, text in self._fleet.notes():
            _LOGS[level]("%s", text)
        self._diagnostics.publish(as_message(self._name, self._fleet.findings(self._now())))

    def report(self, request: TriggerRequest) -> TriggerResponse:
        """Answer with a table."""
        self.check_ages(0.0)
        findings = self._fleet.findings(self._now())
        return TriggerResponse(findings[0].level is Level.OK, as_table(findings))


def main() -> None:
    """Run the node until it is shut down."""
    run("fleet_monitor", FleetMonitor)
