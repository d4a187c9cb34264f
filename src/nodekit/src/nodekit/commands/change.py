"""Command ``rosrun nodekit change``: change of several parameters of a node, all or none."""

import argparse
import shlex
import sys
from typing import Any, Dict, List

import rosgraph
import rospy
import yaml

from nodekit.commands.request_errors import exit_on_error
from nodekit.service_hint import service_hint
from nodekit.master import MasterClient
from nodekit.node.parameter_client import ChangeRefused, ParameterClient
from nodekit.package_version import ShowVersion
from nodekit.parameter_server.parameter_services import CHANGE


def main() -> None:
    """Change parameters of one node: all, or none if one is rejected."""
    parser = argparse.ArgumentParser(
        prog="change",
        description="Change parameters of a running node: all, or none if one is rejected.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.add_argument("namespace", metavar="NAMESPACE", help="the node")
    parser.add_argument(
        "settings",
        metavar="NAME VALUE",
        nargs=argparse.REMAINDER,
        help="one or more pairs; values as for rosparam set",
    )
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        settings = _settings(arguments.namespace, arguments.settings)
    except (ValueError, LookupError, yaml.YAMLError) as error:
        parser.error(str(error))
    with exit_on_error("change", arguments.namespace):
        sys.exit(_change(rosgraph.names.make_global_ns(arguments.namespace), settings))


def _settings(namespace: str, words: List[str]) -> Dict[str, Any]:
    if not words or len(words) % 2:
        hint = ""
        node, _, name = namespace.rpartition("/")
        if len(words) == 1 and node and name:  # /node/parameter, as for rosparam set
            hint = f"; did you mean: rosrun nodekit change {node} {name} {shlex.quote(words[0])}"
        raise ValueError(f"a name and a value are needed for each parameter{hint}")
    return {name: yaml.safe_load(text) for name, text in zip(words[::2], words[1::2])}


def _change(namespace: str, settings: Dict[str, Any]) -> int:
    master, node = MasterClient("/change"), namespace.rstrip("/")
    if master.lookup_service(f"{node}/{CHANGE}") is None:
        hint = service_hint(master, CHANGE, node)
        print(f"change: no node at {namespace} accepts changes; {hint}", file=sys.stderr)
        return 1
    try:
        in_force = ParameterClient(node).change(settings)
    except ChangeRefused as refusal:
        print(f"change: {refusal}", file=sys.stderr)
        return 1
    asked = {name: in_force[name] for name in settings}
    print(yaml.safe_dump(asked, sort_keys=False, allow_unicode=True, width=1000), end="")
    return 0
