"""Command ``rosrun nodekit describe``: parameters of a node, with ranges, units and help."""

import argparse
import shutil
import sys
from concurrent import futures
from typing import Any, Dict, Iterator, List

import rosgraph
import rospy
import yaml
from std_srvs.srv import Trigger

from nodekit.commands.parameter_table import as_table
from nodekit.commands.request_errors import exit_on_error
from nodekit.service_hint import service_hint
from nodekit.master import MasterClient
from nodekit.node.clients import ANSWER_S, CallError, call_service
from nodekit.parameter_server.parameter_services import DESCRIBE
from nodekit.package_version import ShowVersion
from nodekit.parameters.schema import DescriptionError, description_in

#: Longest wait for all responses before printing, so that names are in order [s].
_ORDER_S = 0.5
#: Most nodes that are queried at a time.
_TOGETHER = 50


def main() -> None:
    """Print the descriptions of parameters of the nodes below a namespace.

    A table is as wide as the terminal, 80 columns without one, or COLUMNS.
    """
    parser = argparse.ArgumentParser(
        prog="describe",
        description="Describe the parameters of running nodes: value, type, range, unit and help.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.add_argument("namespace", metavar="NAMESPACE", help="a node or a group; / for all")
    parser.add_argument("--yaml", action="store_true", help="print YAML for programs to read")
    arguments = parser.parse_args(rospy.myargv()[1:])
    with exit_on_error("describe", arguments.namespace):
        sys.exit(_describe(rosgraph.names.make_global_ns(arguments.namespace), arguments.yaml))


def _describe(namespace: str, wants_yaml: bool) -> int:
    master = MasterClient("/describe")
    names = master.namespaces_offering(DESCRIBE, namespace)
    if not names:
        hint = service_hint(master, DESCRIBE, namespace)
        print(f"describe: no node at {namespace} describes its parameters; {hint}", file=sys.stderr)
    parts = [names[start : start + _TOGETHER] for start in range(0, len(names), _TOGETHER)]
    answered = [_describe_together(part, wants_yaml) for part in parts]
    return 0 if names and all(answered) else 1


def _describe_together(names: List[str], wants_yaml: bool) -> bool:
    """Describe nodes, slow ones last; return whether all have responded."""
    calls = {name: call_service(f"{name}/{DESCRIBE}", Trigger) for name in names}
    columns = shutil.get_terminal_size().columns
    missing = 0
    for name in _by_response(calls):
        try:
            entries = description_in(calls[name].result().message)
            text = f"{name}\n{as_table(entries, columns)}\n"
        except CallError as error:
            print(f"describe: {name} does not answer: {error}", file=sys.stderr)
            missing += 1
            continue
        except (
            DescriptionError,
            LookupError,
            TypeError,
        ):  # another node's service with the same name
            print(f"describe: {name}/{DESCRIBE} does not describe parameters", file=sys.stderr)
            missing += 1
            continue
        if wants_yaml:
            text = yaml.safe_dump({name: entries}, sort_keys=False, allow_unicode=True)
        print(text, end="", flush=True)
    return not missing


def _by_response(calls: Dict[str, Any]) -> Iterator[str]:
    """Return the names of those that respond quickly, in order, then the others as they respond.

    :param calls: calls by name
    """
    names = {call: name for name, call in calls.items()}
    done, late = futures.wait(names, _ORDER_S)
    yield from sorted(names[call] for call in done)
    while late:
        done, late = futures.wait(late, ANSWER_S, futures.FIRST_COMPLETED)
        if not done:
            done, late = late, set()  # their time is over
        yield from sorted(names[call] for call in done)
