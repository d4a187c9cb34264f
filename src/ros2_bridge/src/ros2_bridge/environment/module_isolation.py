"""Isolation of rospy's modules from rclpy's: both bring packages called std_msgs.

What ROS 1 needs is imported first and then taken out of Python's list of modules: what is loaded
keeps its references. From then on such a name is ROS 2's. ROS 1's other types are read from their
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
    """Import ROS 1, then make way for ROS 2.

    To be called first of all, by the environment's Python with ROS 1's packages in PYTHONPATH.
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
        warnings.simplefilter("ignore", DeprecationWarning)  # old names of nodekit are among them
        for name in nodekit.__all__:  # what is imported later would find ROS 2's std_srvs
            getattr(nodekit, name)
    index = pathlib.Path(sys.prefix, "share", "ament_index", "resource_index")
    clashing = set(os.listdir(str(index / "rosidl_interfaces")))
    for name in list(sys.modules):
        if name.partition(".")[0] in clashing:
            del sys.modules[name]
    given = [place for place in os.environ.get("PYTHONPATH", "").split(":") if place]
    sys.path[:] = [place for place in sys.path if place not in given] + given
    # rclpy writes its log there where there is no HOME.
    if "HOME" not in os.environ:
        os.environ.setdefault("ROS_LOG_DIR", os.path.join(os.sep, "tmp", "ros2_bridge"))
