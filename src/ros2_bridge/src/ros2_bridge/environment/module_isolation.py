"""Isolation of rospy's modules from rclpy's: both have packages such as std_msgs.

The modules of ROS 1 are imported first and then removed from ``sys.modules``; loaded code keeps its
references. From then on, these names import ROS 2. Other ROS 1 types are read from their definition
files, not imported.
"""

import importlib
import os
import pathlib
import sys
import warnings

import nodekit
from nodekit.entry_point import import_ros


def join() -> None:
    """Import ROS 1, then free its module names for ROS 2.

    Call it first, in the environment's Python with ROS 1's packages in PYTHONPATH.
    """
    import_ros()
    for name in (
        "rospy",
        "genmsg",
        "rospkg",
        "nodekit.master",
        "ros2_bridge.environment.ros1_messages",
    ):
        importlib.import_module(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # deprecated names of nodekit
        for name in nodekit.__all__:  # later imports would find ROS 2's std_srvs
            getattr(nodekit, name)
    index = pathlib.Path(sys.prefix, "share", "ament_index", "resource_index")
    clashing = set(os.listdir(str(index / "rosidl_interfaces")))
    for name in list(sys.modules):
        if name.partition(".")[0] in clashing:
            del sys.modules[name]
    given = [place for place in os.environ.get("PYTHONPATH", "").split(":") if place]
    sys.path[:] = [place for place in sys.path if place not in given] + given
    # Without HOME, rclpy needs another folder for its log.
    if "HOME" not in os.environ:
        os.environ.setdefault("ROS_LOG_DIR", os.path.join(os.sep, "tmp", "ros2_bridge"))
