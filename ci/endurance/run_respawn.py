"""Kill each node, again and again, while roslaunch restarts it."""

import os
import pathlib
import signal
import statistics
import time
import xmlrpc.client
from typing import Any, Dict, List, NamedTuple, Tuple

import rosgraph

from ..benchmark.recorder import wait_until
from .checks import Check, at_most, none_of, reported
from .context import UNDISTURBED, Soak
from .graph_state import Registrations, address, of_node
from .watching import ANSWER, LOG, SIGNAL, TEXT, Watch

TIMES = 50
#: Longest time until a stream is back after its node [s].
BACK_WITHIN = 2.0
LAUNCH_FILE = pathlib.Path(__file__).with_name("nodes.launch")

#: The streams that stop with each node.
AFFECTED = {
    "/talker": ("/chatter", "/rosout"),
    "/listener": ("/rosout",),
    "/signal_generator": ("/signal", "/proc_signal"),
    "/process": ("/proc_signal",),
}


class Return(NamedTuple):
    """Time from a node's end to its registration, and from there to messages of all streams [s]."""

    start: float
    resumed: float


def run(soak: Soak) -> List[Check]:
    """Kill every node in turn."""
    session = soak.session
    launch = session.start(["roslaunch", str(LAUNCH_FILE)])
    with session.node() as node:
        watches = [
            Watch(node, "/chatter", TEXT),
            Watch(node, "/signal", SIGNAL),
            Watch(node, "/proc_signal", ANSWER),
            # The listener logs what it hears.
            Watch(node, "/rosout", LOG, keep=lambda message: b"I heard" in message),
        ]
        streams = {watch.topic: watch for watch in watches}
        for name in AFFECTED:
            session.wait_for(name)
        for watch in watches:
            wait_until(lambda: watch.arrivals.count, 30.0, "message on " + watch.topic)
        before = {name: of_node(node.master, name) for name in AFFECTED}
        returns: Dict[str, List[Return]] = {name: [] for name in AFFECTED}
        silences: Dict[str, float] = {topic: 0.0 for topic in ("/signal", "/proc_signal")}
        wrong: List[str] = []
        for _ in range(soak.times or TIMES):
            for name in AFFECTED:
                came_back, found = kill(node.master, name, streams, before[name])
                returns[name].append(came_back)
                wrong += found
                for topic in set(silences) - set(AFFECTED[name]):
                    silences[topic] = max(silences[topic], streams[topic].arrivals.longest_gap)
        wrong += duplicates(node.master)
    session.stop(launch)
    return report(returns, silences, wrong)


def kill(
    master: rosgraph.Master, name: str, streams: Dict[str, Watch], before: Registrations
) -> Tuple[Return, List[str]]:
    """Kill a node and wait for its return.

    :param before: its registrations before
    :returns: how it came back, and what is wrong with its registrations
    """
    was = address(master, name)
    with xmlrpc.client.ServerProxy(str(was)) as proxy:
        answer: Any = proxy.getPid("/soak")
    for watch in streams.values():
        watch.restart()
    os.kill(answer[2], signal.SIGKILL)
    killed = time.monotonic()
    wait_until(lambda: address(master, name) not in (was, None), 30.0, "return of " + name)
    back = time.monotonic()
    for topic in AFFECTED[name]:
        streams[topic].restart()  # what was on the way when the node was killed does not count
    for topic in AFFECTED[name]:
        wait_until(lambda: streams[topic].arrivals.count, 30.0, "message on " + topic)
    resumed = time.monotonic() - back
    wait_until(lambda: of_node(master, name) == before, 10.0, "registrations of " + name)
    time.sleep(0.3)
    now = of_node(master, name)
    wrong = [] if now == before else [f"{name}: {now} instead of {before}"]
    return Return(back - killed, resumed), wrong


def duplicates(master: rosgraph.Master) -> List[str]:
    """Return the nodes that are not where the master says, and names that are registered twice."""
    wrong = []
    for name in AFFECTED:
        try:
            with xmlrpc.client.ServerProxy(str(address(master, name))) as proxy:
                answer: Any = proxy.getName("/soak")
            if answer[2] != name:
                wrong.append(f"{name}: {answer[2]} answers there")
        except (OSError, xmlrpc.client.Error) as error:
            wrong.append(f"{name}: {error}")
    for part in master.getSystemState():
        wrong += [f"{topic}: {names}" for topic, names in part if len(set(names)) != len(names)]
    return wrong


def report(
    returns: Dict[str, List[Return]], silences: Dict[str, float], wrong: List[str]
) -> List[Check]:
    """Return the figures."""
    checks = []
    for name, of_name in returns.items():
        starts = [one.start for one in of_name]
        figure = f"{statistics.median(starts):.2f} s, at most {max(starts):.2f} s"
        checks.append(reported(f"{name} killed {len(of_name)} times: back after", figure))
        longest = max(one.resumed for one in of_name)
        checks.append(at_most("its streams resume within", round(longest, 3), BACK_WITHIN, "s"))
    for topic, gap in silences.items():
        what = f"longest silence of {topic} while others die"
        checks.append(at_most(what, round(1e3 * gap, 1), 1e3 * UNDISTURBED, "ms"))
    return [*checks, none_of("stale or duplicate registrations", wrong)]
