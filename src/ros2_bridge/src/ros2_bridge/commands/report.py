"""Command ``rosrun ros2_bridge report``: the health of the running bridge, as a table."""

import argparse
import sys
from typing import NoReturn

import rospy
from std_srvs.srv import Trigger

from nodekit import CallError, MasterUnreachable, call_service
from nodekit.master import MasterClient
from nodekit.package_version import ShowVersion
from ros2_bridge.ros1.single_instance import domain, marker

#: Exit statuses.
ALL_WELL, SOMETHING_WRONG, NO_ANSWER = 0, 1, 2
#: Timeout for a response of the bridge [s].
_TIMEOUT_S = 5.0


def main() -> None:
    """Print the table of the bridge to ROS_DOMAIN_ID; exit with 0 if all is well."""
    parser = argparse.ArgumentParser(
        prog="report",
        description="Print rates, losses and queues of the topics that the bridge to the ROS 2"
        " domain ROS_DOMAIN_ID forwards, and what it does not bridge.",
        epilog="Exit status: 0 if all is well, 1 if something is wrong, 2 if there is no answer.",
    )
    parser.add_argument("--version", action=ShowVersion, package="ros2_bridge")
    parser.parse_args(rospy.myargv()[1:])
    try:
        name = marker()
        master = MasterClient("/ros2_bridge_report")
        if master.lookup_service(name) is None:
            _exit_with_error(
                f"no bridge to domain {domain()} is running; start one with 'roslaunch ros2_bridge"
                " bridge.launch', or set ROS_DOMAIN_ID to the domain of a running bridge"
            )
        node = call_service(name, Trigger, timeout=_TIMEOUT_S).result().message
        answer = call_service(f"{node}/report", Trigger, timeout=_TIMEOUT_S).result()
    except ValueError as error:
        _exit_with_error(str(error))
    except MasterUnreachable as error:
        _exit_with_error(f"no master at {error}")
    except CallError as error:
        _exit_with_error(f"the bridge does not answer: {error}")
    except KeyboardInterrupt:
        sys.exit(130)  # the shell's convention for SIGINT
    print(answer.message)
    sys.exit(ALL_WELL if answer.success else SOMETHING_WRONG)


def _exit_with_error(why: str) -> NoReturn:
    print(f"report: {why}", file=sys.stderr)
    sys.exit(NO_ANSWER)
