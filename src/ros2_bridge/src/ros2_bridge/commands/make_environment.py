"""Command ``rosrun ros2_bridge make_environment``: the Python environment that the bridge runs in.

``ci/ros2`` calls it in the workspace. On failure the exit status is 125, with one message.
"""

import argparse
import os
import pathlib
import signal

import rospkg

from nodekit.package_version import ShowVersion
from ros2_bridge.environment import command_line, python_environment
from ros2_bridge.environment.start import home


def main() -> int:
    """Create or update the environment.

    :returns: exit status
    """
    package = pathlib.Path(rospkg.RosPack().get_path("ros2_bridge"))
    parser = argparse.ArgumentParser(
        prog="make_environment",
        description="Create the Python environment with ROS 2 that the bridge runs in.",
    )
    parser.add_argument("--version", action=ShowVersion, package="ros2_bridge")
    parser.add_argument(
        "--into",
        metavar="FOLDER",
        type=pathlib.Path,
        default=home(os.environ),
        help="where to create it (default: %(default)s)",
    )
    parser.add_argument(
        "--sources",
        metavar="FOLDER",
        type=pathlib.Path,
        help="make twins for the packages there, at any depth, not for those installed with the"
        " bridge; twins of earlier runs stay",
    )
    parser.add_argument(
        "--command-line",
        action="store_true",
        help="install the official command ros2 too, from its source on GitHub",
    )
    options = parser.parse_args()
    packages = python_environment.debian_packages()
    packages.update(
        python_environment.packages_under(options.sources)
        if options.sources
        else python_environment.companions(package)
    )
    environment = python_environment.PythonEnvironment(options.into.absolute())
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        environment.make(package / "config" / "wheels.txt", packages)
        if options.command_line:
            command_line.install(environment, package / "config" / "command_line.txt")
    except python_environment.Unavailable as reason:
        python_environment.say(str(reason))
        return 125
    except OSError as error:  # most often a folder that is read-only, or a full disk
        remedy = "if the folder is not writable, choose another with --into"
        python_environment.say(f"cannot create {options.into}: {error}; {remedy}")
        return 125
    except KeyboardInterrupt:
        python_environment.say("interrupted: run it again")
        return 130
    return 0
