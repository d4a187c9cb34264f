"""Kill and stop managed nodes at random, under a manager that recovers the system."""

import pathlib
import random
import signal
import statistics
import subprocess
import time
from typing import Dict, List, NamedTuple, Optional

from ..benchmark.peer_programs import executable
from ..benchmark.recorder import wait_until
from .checks import Check, at_most, none_of, reported
from .context import Soak
from .transition_log import Entry, NodeStates, entries

ORDER = ("/first", "/second", "/third")
NODE = pathlib.Path(__file__).with_name("logging_node.py")
#: Longest time until all are active after the return of a node [s].
ACTIVE_WITHIN = 3.0
#: Longest time until the first of the others is brought down after a loss [s].
NOTICED_WITHIN = 1.0
#: Longest time until a killed node is restarted, and that a node is stopped [s].
LONGEST_PAUSE, LONGEST_STOP = 1.0, 3.0


class Loss(NamedTuple):
    """Time from a node's loss until another is deactivated, and from its return to recovery [s]."""

    kind: str
    noticed: Optional[float]
    resumed: float


class System:
    """Three nodes with a log of their transitions, and their manager."""

    def __init__(self, soak: Soak) -> None:
        self._session = soak.session
        self._log = soak.session.directory / "transitions.log"
        self._log.touch()
        soak.session.environment["TRANSITION_LOG"] = str(self._log)
        self.nodes: Dict[str, "subprocess.Popen[bytes]"] = {}
        for name in ORDER:
            self.start(name)
        names = ", ".join(name[1:] for name in ORDER)
        arguments = [f"_node_names:=[{names}]", "_autostart:=true"]
        self._session.start(executable("lifecycle_manager", "lifecycle_manager", *arguments))

    def start(self, name: str) -> None:
        """Start a node."""
        self.nodes[name] = self._session.start([str(NODE), f"__name:={name[1:]}"])

    def write_down(self, name: str, what: str) -> float:
        """Log what is done to a node; return the time [s]."""
        now = time.monotonic()
        with self._log.open("ab", buffering=0) as log:
            log.write(f"{now} {name} {what}\n".encode())
        return now

    def entries(self, what: str, since: float) -> List[Entry]:
        """Return the events of one type since a time."""
        found = entries(self._log.read_text())
        return [one for one in found if one.moment > since and one.what == what]

    def node_states(self) -> NodeStates:
        """Return the state of the nodes now."""
        node_states = NodeStates(ORDER)
        for entry in entries(self._log.read_text()):
            node_states.read(entry)
        return node_states

    def wait_until_active(self) -> None:
        """Wait until all nodes are active."""
        wait_until(lambda: self.node_states().all_active(), 30.0, "system that is active")

    def lose(self, name: str, chance: random.Random) -> Loss:
        """Kill or stop a node, bring it back, and wait until all are active."""
        process, is_kill = self.nodes[name], chance.random() < 0.5
        kind = "killed" if is_kill else "stopped"
        lost = self.write_down(name, kind)
        process.send_signal(signal.SIGKILL if is_kill else signal.SIGSTOP)
        time.sleep(chance.uniform(0.0, LONGEST_PAUSE if is_kill else LONGEST_STOP))
        if is_kill:
            self.start(name)
            wait_until(lambda: self.entries("started", lost), 30.0, "start of " + name)
            back = self.entries("started", lost)[0].moment
        else:
            back = self.write_down(name, "continued")
            process.send_signal(signal.SIGCONT)
        time.sleep(0.2)  # after a short stop, its silence may be noticed only now
        self.wait_until_active()
        down = [one.moment - lost for one in self.entries("deactivated", lost) if one.node != name]
        up = [one.moment - back for one in self.entries("activated", lost)]
        return Loss(kind, min(down, default=None), max(up, default=0.0))


def run(soak: Soak) -> List[Check]:
    """Lose a node, again and again."""
    chance, system = random.Random(soak.seed), System(soak)
    system.wait_until_active()
    losses = []
    for _ in range(soak.times):
        time.sleep(chance.uniform(0.0, 0.5))
        losses.append(system.lose(chance.choice(ORDER), chance))
    node_states, resumed = system.node_states(), [loss.resumed for loss in losses]
    checks = [
        reported("active again after the return, median", f"{statistics.median(resumed):.2f} s"),
        at_most("the longest", round(max(resumed), 3), ACTIVE_WITHIN, "s"),
        none_of("activated while one before it is not configured", node_states.rash),
        at_most(
            "active while one before it is lost", round(node_states.longest, 3), NOTICED_WITHIN, "s"
        ),
    ]
    for kind in ("killed", "stopped"):
        noticed = [loss.noticed or 0.0 for loss in losses if loss.kind == kind]
        what = f"the others come down after one was {kind} ({len(noticed)} times), within"
        checks.append(at_most(what, round(max(noticed, default=0.0), 3), NOTICED_WITHIN, "s"))
    return checks
