"""Command ``rosrun robot_interfaces_demo fleet_report``: report of a fleet_monitor."""

import argparse
import sys
from typing import NoReturn

import rosgraph
import rospy
from std_srvs.srv import Trigger

from nodekit import CallError, MasterUnreachable, call_service
from nodekit.master import MasterClient
from nodekit.package_version import ShowVersion
from nodekit.service_hint import service_hint

#: Base name of the service of a fleet_monitor.
SERVICE = "report"
#: Exit statuses.
ALL_WELL, SOMETHING_WRONG, NO_ANSWER = 0, 1, 2


def main() -> None:
    """Print the table of a fleet_monitor; the exit status is 0 if all is well."""
    arguments = _parser().parse_args(rospy.myargv()[1:])
    node = arguments.node
    try:
        master = MasterClient("/fleet_report")
        if master.lookup_service(f"{node}/{SERVICE}") is None:
            _exit_with_error(
                f"there is no fleet_monitor {node}; {service_hint(master, SERVICE, node)}"
            )
        answer = call_service(f"{node}/{SERVICE}", Trigger, timeout=arguments.timeout).result()
    except MasterUnreachable as error:
        _exit_with_error(f"no master at {error}")
    except CallError as error:
        _exit_with_error(f"{node} does not answer: {error}")
    except KeyboardInterrupt:
        sys.exit(130)  # the shell's convention for SIGINT
    print(answer.message)
    sys.exit(ALL_WELL if answer.success else SOMETHING_WRONG)


def _exit_with_error(why: str) -> NoReturn:
    print(f"fleet_report: {why}", file=sys.stderr)
    sys.exit(NO_ANSWER)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fleet_report",
        description="Print the state of the robots of a fleet_monitor.",
        epilog="Exit status: 0 if all is well, 1 if something is wrong, 2 if there is no answer.",
    )
    parser.add_argument("--version", action=ShowVersion, package="robot_interfaces_demo")
    parser.add_argument(
        "node",
        metavar="NODE",
        nargs="?",
        type=_global_name,
        default="fleet_monitor",
        help="its name (%(default)s)",
    )
    wait = "longest wait for the answer, s (%(default)g)"
    parser.add_argument("--timeout", metavar="S", type=_seconds, default=2.0, help=wait)
    return parser


def _global_name(text: str) -> str:
    if rosgraph.names.is_private(text):
        raise argparse.ArgumentTypeError(f"{text!r}: must not be private: of which node?")
    return str(rosgraph.names.make_global_ns(text)).rstrip("/")


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds <= 3600.0:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number above 0, at most 3600")
    return seconds
