"""Command ``rosrun nodekit host``: many nodes in one process."""

import argparse
import importlib

import rospy

from nodekit.node.name_rules import IllegalName, check_base_name
from nodekit.package_version import ShowVersion
from nodekit.process.host import Member, host


def main() -> None:
    """Run nodes in one process until it is shut down."""
    parser = argparse.ArgumentParser(
        prog="host",
        description="Run nodes of any packages in one process. Messages between"
        " them need no connection, and no other process has to be woken up.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.add_argument(
        "members",
        metavar="MEMBER",
        nargs="+",
        type=member,
        help="MODULE:CLASS, such as basic_comms.nodes.talker:Talker; the node is named after the"
        " module, talker, unless a name is given: robot1/talker=...",
    )
    host("host", parser.parse_args(rospy.myargv()[1:]).members)


def member(text: str) -> Member:
    """Return a node to host.

    :param text: ``MODULE:CLASS``, or the same with ``NAME=`` in front
    :returns: its base name, namespace and class
    :raises argparse.ArgumentTypeError: if the name is illegal or the class missing
    """
    name, _, place = text.rpartition("=")
    module, _, cls = place.partition(":")
    name = name or module.rpartition(".")[2]
    base = name.rpartition("/")[2]
    if not cls:
        raise argparse.ArgumentTypeError(f"'{text}': must be MODULE:CLASS")
    try:
        check_base_name(base)
        found = getattr(importlib.import_module(module), cls)
    except (IllegalName, ImportError, AttributeError, TypeError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"'{text}': {error}") from None
    if not callable(found):
        raise argparse.ArgumentTypeError(f"'{text}': {cls} is not a class")
    return base, name[: len(name) - len(base)], found
