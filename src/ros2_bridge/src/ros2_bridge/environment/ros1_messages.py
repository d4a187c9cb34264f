"""ROS 1 message classes of the bridge itself, under names that ROS 2's do not replace.

A module of its own, as it is imported after rospy and before rclpy, while these names are still ROS
1's: see :mod:`ros2_bridge.environment.module_isolation`.
"""

from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

__all__ = ["GoalID", "GoalStatus", "GoalStatusArray", "Header", "Log", "String", "Trigger"]
