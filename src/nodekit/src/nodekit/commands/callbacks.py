"""Command ``rosrun nodekit callbacks``: calls, drops and longest times of executor callbacks."""

import argparse
import sys
from typing import Any, Dict, List

import rosgraph
import rospy
import yaml
from std_srvs.srv import Trigger

from nodekit.commands.request_errors import exit_on_error
from nodekit.service_hint import is_running, service_hint
from nodekit.executors import SERVICE
from nodekit.master import MasterClient
from nodekit.package_version import ShowVersion
from nodekit.node.clients import call_service

#: Keys of times, which the table shows in ms.
_TIMES = ("longest", "longest_wait")


def main() -> None:
    """Print the report of a node with an executor about its callbacks."""
    parser = argparse.ArgumentParser(
        prog="callbacks",
        description="List the callbacks of a running node that uses an executor: how much is"
        " waiting and was dropped, and how long calls took and waited, in ms.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.add_argument("node", metavar="NODE", help="name of the node")
    node = rosgraph.names.make_global_ns(parser.parse_args(rospy.myargv()[1:]).node).rstrip("/")
    with exit_on_error("callbacks", node):
        master = MasterClient("/callbacks")
        if master.lookup_service(f"{node}/{SERVICE}") is None:
            sys.exit(f"callbacks: {_problem(master, node)}")
        answer = call_service(f"{node}/{SERVICE}", Trigger).result()
        print(as_table(yaml.safe_load(answer.message)))


def _problem(master: MasterClient, node: str) -> str:
    """Return why a node does not report on callbacks, and what to do."""
    if is_running(master, node):
        advice = "add it to an executor in its program: SingleThreadedExecutor().add_node(node)"
        return f"{node} runs but has no executor; {advice}"
    return f"{node} has no executor; {service_hint(master, SERVICE, node)}"


def as_table(entries: List[Dict[str, Any]]) -> str:
    """Return callbacks as lines of text with aligned columns.

    :param entries: the node's report of each
    """
    rows = [list(entries[0])] if entries else []
    for entry in entries:
        cells = {**entry, **{key: f"{1e3 * entry[key]:.1f}" for key in _TIMES}}
        rows.append([str(cell) for cell in cells.values()])
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)
