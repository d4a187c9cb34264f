"""Kill each node the hard way, again and again, while roslaunch starts it anew."""

import os
import pathlib
import signal
import time
import xmlrpc.client
from typing import Any, Dict, List, NamedTuple, Tuple

from ..benchmark.observers import wait_until
from ..benchmark.tcpros import Node
from .checks import Check, at_most, none_of, reported
from .graph_state import Registrations, address, of_node
from .streams import Arrivals
from .surroundings import Soak
from .watching import ANSWER, LOG, SIGNAL, TEXT, Watch

TIMES = 50
#: longest time until a stream is back after its node, s
BACK_WITHIN = 2.0
#: longest silence of a stream that has nothing to do with the node, s
UNDISTURBED = 0.1
LAUNCH_FILE = pathlib.Path(__file__).with_name("nodes.launch")

#: the streams that stop with each node
AFFECTED = {
    "/talker": ("/chatter", "/rosout"),
    "/listener": ("/rosout",),
    "/signal_generator": ("/signal", "/proc_signal"),
    "/process": ("/proc_signal",),
}


class Return(NamedTuple):
    """How a node came back."""

    #: from its end to its registration, s
    start: float
    #: from its registration to the first message of the last stream, s
    resumed: float


def run(soak: Soak) -> List[Check]:
    """Kill every node in turn, so many times each."""
    session = soak.session
    launch = session.start(["roslaunch", str(LAUNCH_FILE)])
    with session.node() as node:
        watches = [
            Watch(node, "/chatter", TEXT),
            Watch(node, "/signal", SIGNAL),
            Watch(node, "/proc_signal", ANSWER),
            # The listener says what it hears.
            Watch(node, "/rosout", LOG, keep=lambda message: b"I heard" in message),
        ]
        streams = {watch.topic: watch for watch in watches}
        for name in AFFECTED:
            session.wait_for(name)
        for watch in watches:
            wait_until(lambda: watch.arrivals.count > 0, 30.0, "message on " + watch.topic)
        before = {name: of_node(node, name) for name in AFFECTED}
        returns: Dict[str, List[Return]] = {name: [] for name in AFFECTED}
        undisturbed: Dict[str, float] = {topic: 0.0 for topic in ("/signal", "/proc_signal")}
        wrong: List[str] = []
        for _ in range(soak.times or TIMES):
            for name in AFFECTED:
                came_back, found = kill(node, name, streams, before[name])
                returns[name].append(came_back)
                wrong += found
                for topic in set(undisturbed) - set(AFFECTED[name]):
                    gap = streams[topic].arrivals.longest_gap
                    undisturbed[topic] = max(undisturbed[topic], gap)
        wrong += duplicates(node)
    session.stop(launch)
    return report(returns, undisturbed, wrong)


def kill(
    node: Node, name: str, streams: Dict[str, Watch], before: Registrations
) -> Tuple[Return, List[str]]:
    """Kill a node and wait for its return.

    :param before: what it was registered for
    :returns: how it came back, and what is wrong with its registrations
    """
    was = address(node, name)
    assert was is not None
    with xmlrpc.client.ServerProxy(was) as proxy:
        answer: Any = proxy.getPid("/soak")
    for watch in streams.values():
        watch.restart()
    os.kill(answer[2], signal.SIGKILL)
    killed = time.monotonic()
    wait_until(lambda: address(node, name) not in (was, None), 30.0, "return of " + name)
    back = time.monotonic()
    # What was still under way when the node was killed counts for nothing.
    seen: Dict[str, Arrivals] = {}
    for topic in AFFECTED[name]:
        streams[topic].arrivals, seen[topic] = Arrivals(), streams[topic].arrivals
    for topic in AFFECTED[name]:
        wait_until(lambda: streams[topic].arrivals.count > 0, 30.0, "message on " + topic)
    resumed = time.monotonic() - back
    wait_until(lambda: of_node(node, name) == before, 10.0, "registrations of " + name)
    time.sleep(0.3)
    now = of_node(node, name)
    wrong = [] if now == before else [f"{name}: {now} instead of {before}"]
    return Return(back - killed, resumed), wrong


def duplicates(node: Node) -> List[str]:
    """Return the nodes that are not where the master says, and the services of the gone."""
    wrong = []
    for name in AFFECTED:
        uri = address(node, name)
        try:
            with xmlrpc.client.ServerProxy(str(uri)) as proxy:
                answer: Any = proxy.getName("/soak")
        except (OSError, xmlrpc.client.Error) as error:
            wrong.append(f"{name}: {error}")
        else:
            if answer[2] != name:
                wrong.append(f"{name}: {answer[2]} answers there")
    for part in node.master("getSystemState"):
        for topic, names in part:
            if len(set(names)) != len(names):
                wrong.append(f"{topic}: {names}")
    return wrong


def report(
    returns: Dict[str, List[Return]], undisturbed: Dict[str, float], wrong: List[str]
) -> List[Check]:
    """Return the figures."""
    checks = []
    for name, of_name in returns.items():
        starts = sorted(one.start for one in of_name)
        checks.append(
            reported(
                f"{name} killed {len(of_name)} times: back after",
                f"{starts[len(starts) // 2]:.2f} s, at most {starts[-1]:.2f} s",
            )
        )
        longest = max(one.resumed for one in of_name)
        checks.append(at_most("its streams resume within", round(longest, 3), BACK_WITHIN, "s"))
    for topic, gap in undisturbed.items():
        what = f"longest silence of {topic} while others die"
        checks.append(at_most(what, round(1e3 * gap, 1), 1e3 * UNDISTURBED, "ms"))
    checks.append(none_of("stale or duplicate registrations", wrong))
    return checks
