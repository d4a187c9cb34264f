"""Startup of a bridge process: rospy and rclpy side by side, with the Python of the environment."""

import importlib
import os
import pathlib
import sys
from typing import List, Mapping, Optional

import rospkg

from nodekit.entry_point import end
from ros2_bridge.environment.middleware import middleware

#: Path of the environment; by default build/ros2 of the workspace (./ci/ros2), or the user's folder
#: (make_environment).
VARIABLE = "ROS2_BRIDGE_ENVIRONMENT"
#: Parts of a complete environment. After an upgrade of Python it has to be created again.
PARTS = ("share/ros2_bridge/names.yaml", f"lib/python{sys.version_info[0]}.{sys.version_info[1]}")
#: Debian's ROS 1 Python packages, which a virtual environment does not include.
DEBIAN = "/usr/lib/python3/dist-packages"


def main(module: str) -> None:
    """Run the ``main`` of a module with rospy and rclpy side by side.

    :param module: name of the module
    """
    if {"-h", "--help"}.intersection(sys.argv[1:]):
        print(importlib.import_module("ros2_bridge.environment.usage").usage(), end="")
        return
    environment = find(os.environ, pathlib.Path(__file__).resolve())
    if environment is None:
        end(
            "bridge: no environment with ROS 2 found: make one with 'rosrun ros2_bridge"
            f" make_environment' (in the workspace: ./ci/ros2), or set {VARIABLE} to one"
        )
    config = pathlib.Path(rospkg.RosPack().get_path("ros2_bridge")) / "config"
    os.environ.update(middleware(os.environ, config / "loopback.xml"))
    if pathlib.Path(sys.prefix).resolve() != environment.resolve():
        python = str(environment / "bin" / "python")
        os.environ["PYTHONPATH"] = python_path(sys.path)
        os.execv(python, [python, *sys.argv])
    try:
        importlib.import_module("ros2_bridge.environment.module_isolation").join()
        importlib.import_module(module).main()
    except KeyboardInterrupt:
        end(0)  # Ctrl-C before rospy took over the signal


def find(environ: Mapping[str, str], here: pathlib.Path) -> Optional[pathlib.Path]:
    """Return the folder of the environment, or None.

    :param environ: variables
    :param here: path of this file
    """
    places: List[pathlib.Path] = [parent / "build" / "ros2" for parent in here.parents]
    places.append(home(environ))
    if environ.get(VARIABLE):
        places = [pathlib.Path(environ[VARIABLE])]
    for place in places:
        if all((place / part).exists() for part in PARTS):
            return place
    return None


def home(environ: Mapping[str, str]) -> pathlib.Path:
    """Return the default folder of the environment for a user of the installed bridge.

    :param environ: variables
    """
    return pathlib.Path(rospkg.get_ros_home(environ)).absolute() / "ros2_bridge"


def python_path(path: List[str]) -> str:
    """Return PYTHONPATH for the environment's Python.

    :param path: module search path of the current Python
    """
    ros1 = [place for place in path if place.endswith("-packages") and place != DEBIAN]
    return ":".join([*ros1, DEBIAN])
