"""Run the course from installed packages, with a user's commands.

``python3 ci packages.deb_proof``, in a system created by ci/deb, prints its checks, and ends with a
status other than 0 at the first fault. With the word ``bridge`` it checks the bridge only, once its
environment is created.
"""

import os
import pathlib
import re
import sys

from .proof import fetched, output, require, running, succeeds, wait_for

SCOPE = "http://127.0.0.1:8097"
#: A node of ROS 2 that receives from a node of ROS 1.
ROS2_SUBSCRIBER = """
import rclpy
from std_msgs.msg import Float32
rclpy.init()
node = rclpy.create_node("subscriber")
received = []
node.create_subscription(Float32, "/proc_signal", received.append, 10)
while not received:
    rclpy.spin_once(node)
"""


def has_master() -> bool:
    return succeeds("rostopic", "list")


def check_course() -> None:
    """Run the coursework, set a parameter, describe a node, open the oscilloscope's page."""
    with running("roslaunch", "basic_comms", "cw1.launch"):
        wait_for("there is a master", has_master)
        output("rostopic", "echo", "-n", "1", "/proc_signal")
        print("/proc_signal is received")
        output("rosparam", "set", "/signal_generator/frequency", "12.0")
        echo = ("rostopic", "echo", "-n", "1", "/signal/frequency")
        wait_for("a parameter takes effect", lambda: "12.0" in output(*echo))
        table = output("rosrun", "nodekit", "describe", "/signal_generator")
        is_described = re.search(r"^\s*frequency\b.*\b12\b", table, re.MULTILINE) is not None
        require(is_described, "the node describes itself")
        scope = ("rosrun", "topic_scope", "scope.py", "--port", SCOPE[-4:], "/signal/signal_y")
        with running(*scope, log="scope.log"):
            wait_for("the oscilloscope's page is served", lambda: bool(fetched(SCOPE)))
            names = re.findall(r'(?:src|href)="(/[^"]+)"', fetched(SCOPE))
            served = any("dygraph" in name for name in names) and all(
                fetched(SCOPE + name) for name in names
            )
            require(served, f"and the {len(names)} files that it names")
    print("Ctrl-C ends the launch file")


def check_managed_system() -> None:
    """Activate three nodes by a manager."""
    with running("roslaunch", "lifecycle_demo", "managed_system.launch"):
        wait_for("there is a master", has_master)
        states = ("rosrun", "nodekit", "lifecycle", "get")
        wait_for("three managed nodes are active", lambda: output(*states).count(": active") == 3)


def check_bridge() -> None:
    """Receive messages of a ROS 1 node in a ROS 2 node."""
    pairs = output("rosrun", "ros2_bridge", "bridge", "--print-pairs")
    require("basic_comms/msg/SignalMsg" in pairs, "basic_comms/signal_msg has a twin")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    python = str(pathlib.Path("~/.ros/ros2_bridge/bin/python").expanduser())
    with running("roslaunch", "basic_comms", "cw1.launch"):
        wait_for("there is a master", has_master)
        with running("roslaunch", "ros2_bridge", "bridge.launch", log="bridge.log"):
            output(python, "-c", ROS2_SUBSCRIBER)
            print("/proc_signal is received in ROS 2")


def put_a_python_first() -> None:
    """Put a python3 without ROS first on the path, as pyenv and conda do."""
    own = pathlib.Path("own_python", "python3").absolute()
    own.parent.mkdir(exist_ok=True)
    own.write_text("#!/bin/sh\necho this is another python >&2\nexit 1\n")
    own.chmod(0o755)
    os.environ["PATH"] = f"{own.parent}:{os.environ['PATH']}"


if __name__ == "__main__":
    names = [
        name for name in os.environ if "ROS" in name or name in ("PYTHONPATH", "CMAKE_PREFIX_PATH")
    ]
    require(not names, f"no variable is ROS's: {names}")
    put_a_python_first()
    if sys.argv[1:] == ["bridge"]:
        check_bridge()
    else:
        check_course()
        check_managed_system()
