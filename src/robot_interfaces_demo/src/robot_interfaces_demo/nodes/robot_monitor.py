"""Robot node that publishes its status."""

import rospy
from std_msgs.msg import Header

from nodekit import (
    EnumParameter,
    FloatParameter,
    IntParameter,
    Node,
    ParameterSet,
    StringParameter,
    run,
)
from robot_custom_interfaces.msg import RobotStatus
from robot_interfaces_demo.modes import name_of
from robot_interfaces_demo.robot_model import FAULTS, RobotModel

#: Fault: publish nothing.
SILENT = "silent"


class RobotMonitorParameters(ParameterSet):
    """Parameters of robot_monitor."""

    robot_name = StringParameter("robot_01", help="name of the robot")
    period = FloatParameter(
        2.0, minimum=0.001, maximum=3600.0, unit="s", help="time between messages"
    )
    messages_per_mode = IntParameter(15, minimum=1, help="messages in each mode")
    fault = EnumParameter("none", choices=(*FAULTS, SILENT), help="fault of the published messages")


class RobotMonitor:
    """Simulated robot that cycles through its modes, and publishes its status periodically.

    :ROS Publishers:
        - ``robot_status`` (robot_custom_interfaces/RobotStatus)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`RobotMonitorParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(RobotMonitorParameters)
        self._model = RobotModel()
        self._log = node.create_rate_limited_log()
        self._publisher = node.create_publisher("robot_status", RobotStatus)
        node.create_timer(lambda: 1.0 / self._parameters.values.period, self.publish_status)

    def publish_status(self, elapsed: float) -> None:
        """Publish the robot's status."""
        settings = self._parameters.values
        status = self._model.step(settings.messages_per_mode)
        if settings.fault == SILENT:
            return
        mode, readings = FAULTS[settings.fault](status)
        header = Header(stamp=rospy.get_rostime(), frame_id="base_link")
        self._publisher.publish(RobotStatus(header, settings.robot_name, mode, readings))
        shown = ", ".join(f"{reading:.2f}" for reading in readings)
        self._log.line(f"{settings.robot_name}: {name_of(mode)}, {shown}")


def main() -> None:
    """Run the node until it is shut down."""
    run("robot_monitor", RobotMonitor)
