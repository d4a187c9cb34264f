"""Goals of actions through the bridge: at random and cancelled at random, then among kills.

Each goal has to end once, with its own result and in a state that it can have. Where a server or
the bridge is killed, it ends as the rules of its client's own ROS say.
"""

import contextlib
import random
import subprocess
import threading
import time
from typing import Callable, Dict, Iterator, List

from ..benchmark.asking import ABORT, SUCCEED, Asker, start
from ..benchmark.bridging import BRIDGE, LIMIT
from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import DOMAIN
from ..benchmark.processes import Session
from .checks import Check, at_most, none_of, reported
from .surroundings import Soak

#: Names of the actions of the servers of either ROS.
NAMES = {"1": "/soak/arm", "2": "/soak/hand"}
#: Pause between two handfuls of goals, s, how many are in each, and how long one takes at most, s.
PAUSE, HANDFUL, LONGEST = 10.0, 5, 4.0
#: how long a goal may take in addition to what it asks for, s
LATE = 10.0
#: how long a goal that is killed would take otherwise, s
LONG = 90.0
#: longest time until a client is told that its server was killed, and one of ROS 1 that the bridge
#: was, s: ROS 2 takes who was killed for alive for 20 s
TOLD_WITHIN = 30.0
#: longest wait for the first feedback until a goal is sent again, s
BEGUN_WITHIN = 5.0
#: states of a goal that was not cancelled, and of one that was, by who asks for it
_BY_ITSELF = {"SUCCEEDED", "ABORTED"}
_CANCELLED = {"1": _BY_ITSELF | {"PREEMPTED", "RECALLED"}, "2": _BY_ITSELF | {"CANCELED"}}


class Goals:
    """A server of each ROS, and a client of each on the other's."""

    def __init__(self, session: Session) -> None:
        self.servers = {ros: start(session, "server", ros, name) for ros, name in NAMES.items()}
        self.askers = {"2": Asker(session, "2", NAMES["1"]), "1": Asker(session, "1", NAMES["2"])}

    def wait(self) -> None:
        """Wait until all are connected."""
        for asker in self.askers.values():
            asker.wait_for_server()

    def close(self) -> None:
        """End all."""
        for asker in self.askers.values():
            asker.close()
        for server in self.servers.values():
            server.kill()


def wrong_with(ros: str, asker: Asker) -> List[str]:
    """Return what is wrong with the goals of a client, all of which should have ended.

    :param ros: the client's
    """
    found = list(asker.strange)
    found += [f"{key} is lost" for key in asker.sent if not asker.ends[key]]
    found += [
        f"{key} was never sent" for key in [*asker.ends, *asker.heard] if key not in asker.sent
    ]
    for key, ends in list(asker.ends.items()):
        states = _CANCELLED[ros] if key in asker.cancelled else _BY_ITSELF
        of_itself = [key] if ends[0][0] != "RECALLED" else [key, "-"]
        if len(ends) > 1 or ends[0][0] not in states or ends[0][1] not in of_itself:
            found.append(f"{key} ended as {ends}")
    return found


@contextlib.contextmanager
def at_random(soak: Soak, checks: List[Check]) -> Iterator[None]:
    """Send goals both ways for a while, and cancel half of them at random moments.

    :param checks: is given what came of them
    """
    goals = Goals(soak.session)
    ended = threading.Event()
    threads = [
        threading.Thread(target=_ask, args=(ros, asker, random.Random(soak.seed), ended))
        for ros, asker in goals.askers.items()
    ]
    try:
        goals.wait()
        for thread in threads:
            thread.start()
        yield
        ended.set()
        for thread in threads:
            thread.join()
        for ros, asker in goals.askers.items():
            with contextlib.suppress(TimeoutError):  # what is lost is told below
                wait_until(lambda: len(asker.ends) >= len(asker.sent), LATE + LONGEST, "end")
            states = [ends[0][0] for ends in asker.ends.values()]
            counts = ", ".join(f"{states.count(one)} {one}" for one in sorted(set(states)))
            what = f"goals of ROS {ros} in the other"
            checks.append(reported(what, f"{len(asker.sent)}: {counts}"))
            checks.append(none_of("lost, invented or mistaken", wrong_with(ros, asker)))
    finally:
        ended.set()
        goals.close()


def _ask(ros: str, asker: Asker, chance: random.Random, ended: threading.Event) -> None:
    number = 0
    while not ended.wait(PAUSE):
        cancelled: List[str] = []
        for _ in range(HANDFUL):
            number += 1
            key = f"goal{ros}-{number}"
            asker.send(key, chance.uniform(0.0, LONGEST), chance.choice((SUCCEED, SUCCEED, ABORT)))
            if chance.random() < 0.5:
                cancelled.append(key)
        for key in cancelled:
            time.sleep(chance.uniform(0.0, 0.5))
            asker.cancel(key)


def among_kills(soak: Soak, times: int) -> List[Check]:
    """Kill either server and the bridge in turn while each client has a goal.

    :param times: how often each
    """
    session = soak.session
    on_domain = dict(session.environment, ROS_DOMAIN_ID=DOMAIN)
    running: Dict[str, "subprocess.Popen[bytes]"] = {}
    running["bridge"] = session.start([str(BRIDGE)], on_domain)
    goals = Goals(session)
    running.update(goals.servers)
    begin: Dict[str, Callable[[], "subprocess.Popen[bytes]"]] = {
        "1": lambda: start(session, "server", "1", NAMES["1"]),
        "2": lambda: start(session, "server", "2", NAMES["2"]),
        "bridge": lambda: session.start([str(BRIDGE)], on_domain),
    }
    names = {"1": "server of ROS 1", "2": "server of ROS 2", "bridge": "bridge"}
    told: Dict[str, List[float]] = {target: [] for target in begin}
    wrong: List[str] = []
    try:
        goals.wait()
        for number in range(times):
            for target in begin:
                keys = {
                    ros: _begun(asker, f"{target}-{number}") for ros, asker in goals.askers.items()
                }
                running[target].kill()
                running[target].wait()
                if target == "bridge":
                    running[target] = begin[target]()
                # A client of ROS 2 whose server is only a bridge is not told, as with any server.
                loser = "2" if target == "1" else "1"
                end = "LOST" if target == "bridge" else "ABORTED"
                began, asker, key = time.monotonic(), goals.askers[loser], keys[loser]
                wait_until(lambda: bool(asker.ends[key]), 2.0 * TOLD_WITHIN, f"end of {key}")
                told[target].append(time.monotonic() - began)
                if asker.ends[key] != [[end, "-"]]:
                    wrong.append(f"{key} ended as {asker.ends[key]}")
                other = {"1": "2", "2": "1"}[loser]
                if goals.askers[other].ends[keys[other]]:
                    wrong.append(f"{keys[other]} ended as {goals.askers[other].ends[keys[other]]}")
                goals.askers[other].cancel(keys[other])
                if target != "bridge":
                    running[target] = goals.servers[target] = begin[target]()
    finally:
        goals.close()
        session.stop(running["bridge"])
    for asker in goals.askers.values():
        wrong += asker.strange
    return [
        *(
            at_most(
                f"{names[target]} killed {len(of_one)} times: client told within",
                round(max(of_one), 2),
                TOLD_WITHIN,
                "s",
            )
            for target, of_one in told.items()
        ),
        none_of("goals that ended otherwise than by the rules", wrong),
    ]


def _begun(asker: Asker, name: str) -> str:
    """Return a goal that runs; the first ones may be sent while a server is just coming back.

    :param name: what the goal's own begins with
    """
    give_up, attempt = time.monotonic() + 2.0 * LIMIT, 0
    while time.monotonic() < give_up:
        attempt += 1
        key = f"{name}-{attempt}"
        asker.send(key, LONG)
        with contextlib.suppress(TimeoutError):
            wait_until(lambda: asker.heard[key] > 0, BEGUN_WITHIN, "feedback")
            return key
    raise TimeoutError(f"no goal {name} runs within {2.0 * LIMIT:g} s")
