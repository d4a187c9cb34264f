"""The command ``rosrun nodekit change NAMESPACE NAME VALUE ...``."""

import argparse
import sys
from typing import Any, Dict, List

import rosgraph
import rospy
import yaml

from nodekit.commands.calling import ask, ending_with_a_sentence, master, say_what_there_is
from nodekit.parameter_server.services import CHANGE
from nodekit_msgs.srv import SetParameters


def main() -> None:
    """Change parameters of one node: all or, where one is refused, none."""
    parser = argparse.ArgumentParser(
        prog="change",
        description="Change parameters of a running node: all or, where one is refused, none.",
    )
    parser.add_argument("namespace", metavar="NAMESPACE", help="the node")
    parser.add_argument(
        "settings",
        metavar="NAME VALUE",
        nargs=argparse.REMAINDER,
        help="any number of them; values as rosparam set takes them",
    )
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        settings = _settings(arguments.settings)
    except (ValueError, LookupError, yaml.YAMLError) as error:
        parser.error(str(error))
    with ending_with_a_sentence("change", arguments.namespace):
        sys.exit(_change(rosgraph.names.make_global_ns(arguments.namespace), settings))


def _settings(words: List[str]) -> Dict[str, Any]:
    if not words or len(words) % 2:
        raise ValueError("a name and a value are needed for each parameter")
    return {name: yaml.safe_load(text) for name, text in zip(words[::2], words[1::2])}


def _change(namespace: str, settings: Dict[str, Any]) -> int:
    client, node = master("change"), namespace.rstrip("/")
    if client.lookup_service(f"{node}/{CHANGE}") is None:
        problem = f"change: nothing at {namespace} takes changes"
        say_what_there_is(client, CHANGE, namespace, problem)
        return 1
    answer = ask(f"{node}/{CHANGE}", SetParameters, yaml.safe_dump(settings)).result()
    if not answer.success:
        print(f"change: {answer.message}", file=sys.stderr)
        return 1
    in_force = yaml.safe_load(answer.values)
    asked = {name: in_force[name] for name in settings}
    print(yaml.safe_dump(asked, sort_keys=False, allow_unicode=True, width=1000), end="")
    return 0
