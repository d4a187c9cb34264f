"""ROS 1 message classes of the bridge itself, under names that ROS 2 modules do not replace.

A separate module, because it is imported between rospy and rclpy, while these names still belong to
ROS 1: see :mod:`ros2_bridge.environment.module_isolation`.
"""

from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

__all__ = [
    "DiagnosticArray",
    "DiagnosticStatus",
    "GoalID",
    "GoalStatus",
    "GoalStatusArray",
    "Header",
    "KeyValue",
    "Log",
    "String",
    "Trigger",
]
