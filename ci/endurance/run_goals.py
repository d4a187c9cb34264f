"""Goals of actions through the bridge: cancelled at random, then among kills. Part of run_bridge.

Each goal has to end once, with its own result and in a legal state. If a server or the bridge is
killed, it ends by the rules of its client's own ROS.
"""

import contextlib
import random
import subprocess
import threading
import time
from typing import Callable, Dict, Iterator, List

from ..benchmark.action_client import ABORT, SUCCEED, ActionClient, start
from ..benchmark.bridge import LIMIT, bridge_command
from ..benchmark.processes import Session
from ..benchmark.recorder import wait_until
from .checks import Check, at_most, none_of, reported
from .context import Soak

#: Names of the actions of the servers of either ROS.
NAMES = {"1": "/soak/arm", "2": "/soak/hand"}
OTHER = {"1": "2", "2": "1"}
#: Pause between two groups of goals [s], their size, and the longest duration of a goal [s].
PAUSE, GROUP, LONGEST = 10.0, 5, 4.0
#: Longest time that a goal may take in addition [s].
LATE = 10.0
#: Duration of a goal whose server is killed [s].
LONG = 90.0
#: Longest time until a client learns that its server was killed, and one of ROS 1 that the bridge
#: was [s]: ROS 2 takes a killed process to be alive for 20 s.
TOLD_WITHIN = 30.0
#: Longest wait for the first feedback until a goal is sent again [s].
BEGUN_WITHIN = 5.0
#: Final states of a goal, and of a cancelled goal by its client's ROS.
_FINAL = {"SUCCEEDED", "ABORTED"}
_CANCELLED = {"1": _FINAL | {"PREEMPTED", "RECALLED"}, "2": _FINAL | {"CANCELED"}}


class Goals:
    """A server of each ROS, and a client of each on the other's, all connected."""

    def __init__(self, session: Session) -> None:
        self.servers = {ros: start(session, "server", ros, name) for ros, name in NAMES.items()}
        self.clients = {ros: ActionClient(session, ros, NAMES[OTHER[ros]]) for ros in NAMES}
        for client in self.clients.values():
            client.wait_for_server()

    def close(self) -> None:
        """End all."""
        for client in self.clients.values():
            client.close()
        for server in self.servers.values():
            server.kill()


def errors(client: ActionClient) -> List[str]:
    """Return what is wrong with the goals of a client, all of which should have ended."""
    found = list(client.strange)
    found += [f"{key} is lost" for key in client.sent if not client.ends[key]]
    found += [
        f"{key} was never sent" for key in [*client.ends, *client.heard] if key not in client.sent
    ]
    for key, ends in [(key, ends) for key, ends in client.ends.items() if ends]:
        states = _CANCELLED[client.ros] if key in client.cancelled else _FINAL
        results = [key] if ends[0][0] != "RECALLED" else [key, "-"]
        if len(ends) > 1 or ends[0][0] not in states or ends[0][1] not in results:
            found.append(f"{key} ended as {ends}")
    return found


@contextlib.contextmanager
def at_random(soak: Soak, checks: List[Check]) -> Iterator[None]:
    """Send goals both ways during the context, and cancel half of them at random moments.

    :param checks: receives the figures
    """
    goals, ended = Goals(soak.session), threading.Event()
    threads = [
        threading.Thread(target=_send, args=(client, random.Random(soak.seed), ended))
        for client in goals.clients.values()
    ]
    try:
        for thread in threads:
            thread.start()
        yield
        ended.set()
        for thread in threads:
            thread.join()
        for ros, client in goals.clients.items():
            with contextlib.suppress(TimeoutError):  # what is lost is reported below
                wait_until(lambda: len(client.ends) >= len(client.sent), LATE + LONGEST, "end")
            states = [ends[0][0] for ends in client.ends.values() if ends]
            counts = ", ".join(f"{states.count(one)} {one}" for one in sorted(set(states)))
            what = f"goals of ROS {ros} in the other"
            checks.append(reported(what, f"{len(client.sent)}: {counts}"))
            checks.append(none_of("lost, invented or mistaken", errors(client)))
    finally:
        ended.set()
        goals.close()


def _send(client: ActionClient, chance: random.Random, ended: threading.Event) -> None:
    number = 0
    while not ended.wait(PAUSE):
        cancelled: List[str] = []
        for _ in range(GROUP):
            number += 1
            key = f"goal{client.ros}-{number}"
            outcome = chance.choice((SUCCEED, SUCCEED, ABORT))
            client.send(key, chance.uniform(0.0, LONGEST), outcome)
            if chance.random() < 0.5:
                cancelled.append(key)
        for key in cancelled:
            time.sleep(chance.uniform(0.0, 0.5))
            client.cancel(key)


def among_kills(soak: Soak, times: int) -> List[Check]:
    """Kill either server and the bridge in turn while each client has a goal.

    :param times: how often each
    """
    session = soak.session
    command, variables = bridge_command()
    begin: Dict[str, Callable[[], "subprocess.Popen[bytes]"]] = {
        "1": lambda: start(session, "server", "1", NAMES["1"]),
        "2": lambda: start(session, "server", "2", NAMES["2"]),
        "bridge": lambda: session.start(command, {**session.environment, **variables}),
    }
    bridge, goals = begin["bridge"](), Goals(session)
    running = {**goals.servers, "bridge": bridge}
    told: Dict[str, List[float]] = {target: [] for target in begin}
    wrong: List[str] = []
    try:
        for number in range(times):
            for target in begin:
                keys = {
                    ros: _begin_goal(client, f"{target}-{number}")
                    for ros, client in goals.clients.items()
                }
                running[target].kill()
                running[target].wait()
                if target == "bridge":
                    running[target] = begin[target]()
                # A client of ROS 2 is not told that the bridge was killed, as with any server.
                loser = "2" if target == "1" else "1"
                end = "LOST" if target == "bridge" else "ABORTED"
                began, client, key = time.monotonic(), goals.clients[loser], keys[loser]
                wait_until(lambda: client.ends[key], 2.0 * TOLD_WITHIN, f"end of {key}")
                told[target].append(time.monotonic() - began)
                other, goal = goals.clients[OTHER[loser]], keys[OTHER[loser]]
                if client.ends[key] != [[end, "-"]]:
                    wrong.append(f"{key} ended as {client.ends[key]}")
                if other.ends[goal]:
                    wrong.append(f"{goal} ended as {other.ends[goal]}")
                other.cancel(goal)
                if target != "bridge":
                    running[target] = goals.servers[target] = begin[target]()
    finally:
        goals.close()
        session.stop(running["bridge"])
    for client in goals.clients.values():
        wrong += client.strange
    names = {"1": "server of ROS 1", "2": "server of ROS 2", "bridge": "bridge"}
    checks = [
        at_most(
            f"{names[target]} killed {len(took)} times: client told within",
            max(took),
            TOLD_WITHIN,
            "s",
        )
        for target, took in told.items()
    ]
    return [*checks, none_of("goals that ended otherwise than by the rules", wrong)]


def _begin_goal(client: ActionClient, name: str) -> str:
    """Return a goal that runs; the first ones may be sent before a server is back.

    :param name: prefix of the goal
    """
    give_up, attempt = time.monotonic() + 2.0 * LIMIT, 0
    while time.monotonic() < give_up:
        attempt += 1
        key = f"{name}-{attempt}"
        client.send(key, LONG)
        with contextlib.suppress(TimeoutError):
            wait_until(lambda: client.heard[key], BEGUN_WITHIN, "feedback")
            return key
    raise TimeoutError(f"no goal {name} runs within {2.0 * LIMIT:g} s")
