"""Run the course from installed packages, with the commands that their user types.

``python3 ci packages.deb_proof``, in a system that ci/deb has made, says what it has seen, and ends
with a status other than 0 at the first command that does not do what it should. With the word
``bridge`` it does so with the bridge alone, once its environment is made.
"""

import os
import pathlib
import re
import sys
import urllib.request
from typing import List

from .proof import PATIENCE, answers, running, said, wait_for

SCOPE = "http://127.0.0.1:8097"
#: A node of ROS 2 that hears a node of ROS 1.
ROS2_EAR = """
import rclpy
from std_msgs.msg import Float32
rclpy.init()
node = rclpy.create_node("ear")
heard = []
node.create_subscription(Float32, "/proc_signal", heard.append, 10)
while not heard:
    rclpy.spin_once(node)
"""


def fetched(path: str) -> str:
    """Return a file that the scope serves."""
    with urllib.request.urlopen(SCOPE + path, timeout=PATIENCE) as reply:
        return str(reply.read().decode())


def served() -> bool:
    """Tell whether the scope serves yet."""
    try:
        return bool(fetched("/"))
    except OSError:
        return False


def course() -> None:
    """Run the coursework, set a parameter, describe a node."""
    with running("roslaunch", "basic_comms", "cw1.launch"):
        wait_for("there is a master", lambda: answers("rostopic", "list"))
        said("rostopic", "echo", "-n", "1", "/proc_signal")
        print("/proc_signal is received")
        said("rosparam", "set", "/signal_generator/frequency", "12.0")
        wait_for(
            "a parameter takes effect",
            lambda: "12.0" in said("rostopic", "echo", "-n", "1", "/signal/frequency"),
        )
        table = said("rosrun", "nodekit", "describe", "/signal_generator")
        if not re.search(r"^\s*frequency\b.*\b12\b", table, re.MULTILINE):
            sys.exit(f"frequency is not described as 12:\n{table}")
        print("the node describes itself")
        scope()
    print("Ctrl-C ends the launch file")


def scope() -> None:
    """Look at the page of the oscilloscope, and at samples."""
    field = "/signal/signal_y"
    with running("rosrun", "topic_scope", "scope.py", "--port", SCOPE[-4:], field):
        wait_for("the oscilloscope's page is served", served)
        names: List[str] = re.findall(r'(?:src|href)="(/[^"]+)"', fetched("/"))
        empty = [name for name in names if not fetched(name)]
        if not any("dygraph" in name for name in names) or empty:
            sys.exit(f"the page names {names}, of which empty are {empty}")
        print(f"and the {len(names)} files that it names")


def managed_system() -> None:
    """Have a manager bring three nodes up."""
    with running("roslaunch", "lifecycle_demo", "managed_system.launch"):
        wait_for("there is a master", lambda: answers("rostopic", "list"))
        wait_for(
            "three managed nodes are active",
            lambda: said("rosrun", "nodekit", "lifecycle", "get").count(": active") == 3,
        )


def bridge() -> None:
    """Have a node of ROS 2 hear one of ROS 1."""
    pairs = said("rosrun", "ros2_bridge", "bridge", "--print-pairs")
    if "basic_comms/msg/SignalMsg" not in pairs:
        sys.exit(f"basic_comms/signal_msg has no twin:\n{pairs}")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    python = str(pathlib.Path("~/.ros/ros2_bridge/bin/python").expanduser())
    with running("roslaunch", "basic_comms", "cw1.launch"):
        wait_for("there is a master", lambda: answers("rostopic", "list"))
        with running("roslaunch", "ros2_bridge", "bridge.launch", log="bridge.log"):
            said(python, "-c", ROS2_EAR)
            print("/proc_signal is received in ROS 2")


def put_a_python_first() -> None:
    """Have a python3 on the path that knows nothing of ROS, as pyenv and conda do."""
    own = pathlib.Path("own_python", "python3").absolute()
    own.parent.mkdir(exist_ok=True)
    own.write_text("#!/bin/sh\necho this is another python >&2\nexit 1\n")
    own.chmod(0o755)
    os.environ["PATH"] = f"{own.parent}:{os.environ['PATH']}"


def main() -> None:
    """Do all of it, without a variable of ROS's."""
    names = [
        name for name in os.environ if "ROS" in name or name in ("PYTHONPATH", "CMAKE_PREFIX_PATH")
    ]
    if names:
        sys.exit(f"the environment has {names}")
    put_a_python_first()
    if sys.argv[1:] == ["bridge"]:
        bridge()
        return
    course()
    managed_system()


if __name__ == "__main__":
    main()
