"""Kill a node repeatedly, and check how its respawned successor comes back.

Only ``respawn="true"`` is needed in the launch file. The rounds are independent of the topics: a
stream is a function that counts received messages.
"""

import os
import signal
import time
from typing import Any, Callable, Dict, List, NamedTuple, Tuple
from xmlrpc.client import ServerProxy

import rosgraph

from nodekit.testing.launching import Launched
from nodekit.testing.waiting import wait_until

#: Counts the messages received so far that a node publishes or causes.
Stream = Callable[[], int]
#: Publications, subscriptions and services of a graph, each as name and node.
Registrations = List[List[Tuple[str, str]]]


class Round(NamedTuple):
    """Return of a node after it was killed.

    :param absent: from the kill to the end of the successor's init_node [s]
    :param silent: from then until its streams are heard again [s]
    """

    absent: float
    silent: float


def kill_rounds(launch: Launched, node: str, streams: List[Stream], count: int) -> List[Round]:
    """Kill a node with SIGKILL and wait for its return, several times.

    :param launch: the running launch, which includes the node
    :param node: global name of the node
    :param streams: streams that continue while the node runs
    :param count: number of rounds
    :returns: the results
    :raises AssertionError: if a stream does not resume in time, another node's process has changed,
        or the master lists duplicate or other registrations
    """
    return [_kill_once(launch, node, streams) for _ in range(count)]


def _kill_once(launch: Launched, node: str, streams: List[Stream]) -> Round:
    before, registered = launch.processes(), registrations()
    killed_at = time.monotonic()
    os.kill(before[node].pid, signal.SIGKILL)
    launch.wait_for_new_process(node, before[node])
    wait_until(lambda: _is_back(launch, node), lambda: node + " did not come back")
    back_at = time.monotonic()
    heard = [stream() for stream in streams]
    wait_until(
        lambda: all(stream() > count for stream, count in zip(streams, heard)),
        lambda: f"of {node} heard {heard}, then {[stream() for stream in streams]}",
    )
    resumed_at = time.monotonic()
    _assert_others_went_on(launch, node, before)
    wait_until(
        lambda: registrations() == registered,
        lambda: f"registered was {registered}, now {registrations()}",
    )
    assert_alive(launch, node)
    return Round(back_at - killed_at, resumed_at - back_at)


def registrations() -> Registrations:
    """Return the master's registrations, sorted, with duplicates."""
    state: Any = rosgraph.Master("/kill_rounds").getSystemState()
    return [sorted((name, node) for name, nodes in part for node in nodes) for part in state]


def assert_alive(launch: Launched, node: str) -> None:
    """Check that all of the master's entries about a node lead to its current process.

    :raises AssertionError: if they do not
    """
    master = rosgraph.Master("/kill_rounds")
    pid = launch.processes()[node].pid
    with ServerProxy(master.lookupNode(node)) as slave:
        answer: Any = slave.getPid("/kill_rounds")
        port = _port(slave)
    assert answer[2] == pid, f"{node} answers from process {answer}, not {pid}"
    for service, owner in registrations()[2]:
        if owner == node:
            uri = master.lookupService(service)
            assert uri.endswith(f":{port}"), f"{service} is at {uri}, not port {port}"


def _port(slave: ServerProxy) -> int:
    """Ask a node for the port of its topics and services; every node publishes /rosout."""
    answer: Any = slave.requestTopic("/kill_rounds", "/rosout", [["TCPROS"]])
    return int(answer[2][2])


def _is_back(launch: Launched, node: str) -> bool:
    """Return whether the registered node is the new process, and has started."""
    try:
        known = launch.graph.pid(node)
    except (OSError, rosgraph.MasterError):
        return False  # still the killed process, or not registered
    return known == launch.processes()[node].pid and launch.graph.initialised(node)


def _assert_others_went_on(launch: Launched, node: str, before: Dict[str, Any]) -> None:
    after = launch.processes()
    for other, process in before.items():
        if other != node:
            now = after.get(other)
            assert now == process, f"{other} was {process} and is {now}"
