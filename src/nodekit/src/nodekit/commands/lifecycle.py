"""Command ``rosrun nodekit lifecycle``: states and transitions of managed nodes."""

import argparse
import sys
from typing import Any, List, Optional

import rosgraph
import rospy

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from nodekit.commands.request_errors import exit_on_error
from nodekit.service_hint import service_hint
from nodekit.lifecycle_states import NotAllowed, State, requested
from nodekit.master import MasterClient
from nodekit.package_version import ShowVersion
from nodekit.node.clients import CallError, call_service

#: Service that only managed nodes offer.
SERVICE = "get_transition_graph"
#: Default time-out of a transition [s].
TRANSITION_S = 60.0


def main() -> None:
    """Show managed nodes, and change their states."""
    arguments = _parser().parse_args(rospy.myargv()[1:])
    node = getattr(arguments, "node", None)
    node = node and rosgraph.names.make_global_ns(node).rstrip("/")
    try:
        with exit_on_error("lifecycle", node or "a node"):
            master = MasterClient("/lifecycle")
            if node and master.lookup_service(f"{node}/{SERVICE}") is None:
                hint = service_hint(master, SERVICE, node)
                sys.exit(f"lifecycle: {node} is not a managed node; {hint}")
            names = [node] if node else master.namespaces_offering(SERVICE)
            sys.exit(arguments.verb(names, arguments))
    except ValueError as error:  # an invalid time-out
        sys.exit(f"lifecycle: {error}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lifecycle", description="Show managed nodes, and change their states."
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    verbs = parser.add_subparsers(metavar="VERB", dest="name", required=True)
    one = verbs.add_parser("nodes", help="list the managed nodes")
    one.set_defaults(verb=_nodes)
    one = verbs.add_parser("get", help="print the state of a node, or of all")
    one.add_argument("node", metavar="NODE", nargs="?", help="name of the node")
    one.set_defaults(verb=_get)
    one = verbs.add_parser("list", help="list the transitions that a node may make now")
    one.add_argument("node", metavar="NODE", help="its name")
    one.add_argument("-a", "--all", action="store_true", help="list all transitions")
    one.set_defaults(verb=_list)
    one = verbs.add_parser("set", help="request a transition of a node")
    one.add_argument("node", metavar="NODE", help="its name")
    one.add_argument("transition", metavar="TRANSITION", help="its label, such as configure, or id")
    wait = "longest wait until it is done, s (%(default)g)"
    one.add_argument("--timeout", metavar="S", type=float, default=TRANSITION_S, help=wait)
    one.set_defaults(verb=_set)
    return parser


def _nodes(names: List[str], _: Any) -> int:
    print("".join(f"{name}\n" for name in names), end="")
    return 0


def _get(names: List[str], arguments: Any) -> int:
    calls = {name: call_service(f"{name}/get_state", GetState) for name in names}
    missing = 0
    for name, call in calls.items():
        try:
            state = call.result().current_state
        except CallError as error:
            print(f"lifecycle: {name} does not answer: {error}", file=sys.stderr)
            missing += 1
            continue
        print(f"{'' if arguments.node else name + ': '}{state.label} [{state.id}]")
    return 1 if missing else 0


def _list(names: List[str], arguments: Any) -> int:
    service = SERVICE if arguments.all else "get_available_transitions"
    answer = call_service(f"{names[0]}/{service}", GetAvailableTransitions).result()
    for each in answer.available_transitions:
        print(f"- {each.transition.label} [{each.transition.id}]")
        print(f"\tStart: {each.start_state.label}\n\tGoal: {each.goal_state.label}")
    return 0


def _set(names: List[str], arguments: Any) -> Optional[str]:
    (name,), wanted = names, arguments.transition
    try:
        transition = requested(_state(name), int(wanted) if wanted.isdecimal() else wanted)
    except NotAllowed as refusal:
        return f"lifecycle: {name}: {refusal}"
    request = Transition(transition.id, transition.label)
    timeout = arguments.timeout
    if call_service(f"{name}/change_state", ChangeState, request, timeout=timeout).result().success:
        print("Transitioning successful")
        return None
    state = _state(name).label
    return f"lifecycle: {transition.label} has failed: {name} is {state}, and its log says why"


def _state(name: str) -> State:
    answer = call_service(f"{name}/get_state", GetState).result().current_state
    return State(answer.id, answer.label)
