"""Kill and stop managed nodes at random, under a manager that brings the system back."""

import pathlib
import random
import signal
import subprocess
import time
from typing import Dict, List, NamedTuple, Optional

from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import WORKSPACE
from .checks import Check, at_most, none_of, reported
from .diary import Entry, Story, entries
from .surroundings import Soak

TIMES = 50
ORDER = ("/first", "/second", "/third")
NODE = pathlib.Path(__file__).with_name("diary_node.py")
MANAGER = WORKSPACE / "devel" / "lib" / "lifecycle_manager" / "lifecycle_manager"
#: longest time until all are active after the return of one, s
ACTIVE_WITHIN = 3.0
#: longest time until the first of the others is brought down after a loss, s
NOTICED_WITHIN = 1.0
#: longest time until a node that was killed is started again, and that one is stopped, s
LONGEST_PAUSE = 1.0
LONGEST_STOP = 3.0


class Loss(NamedTuple):
    """How the system got over the loss of a node."""

    what: str
    #: from the loss until another node came down, s; None where none did
    noticed: Optional[float]
    #: from the node's return until all were active, s
    resumed: float


class System:
    """Three nodes and their manager.

    :param soak: where
    """

    def __init__(self, soak: Soak) -> None:
        self._session = soak.session
        self._diary = soak.session.directory / "diary"
        self._diary.touch()
        soak.session.environment["DIARY"] = str(self._diary)
        self.nodes: Dict[str, "subprocess.Popen[bytes]"] = {}
        for name in ORDER:
            self.start(name)
        names = ", ".join(name[1:] for name in ORDER)
        self._session.start([str(MANAGER), f"_node_names:=[{names}]", "_autostart:=true"])

    def start(self, name: str) -> None:
        """Start a node."""
        self.nodes[name] = self._session.start([str(NODE), f"__name:={name[1:]}"])

    def write_down(self, name: str, what: str) -> float:
        """Write down what is done to a node; return when."""
        now = time.monotonic()
        with self._diary.open("ab", buffering=0) as diary:
            diary.write(f"{now} {name} {what}\n".encode())
        return now

    def entries(self, since: float = 0.0) -> List[Entry]:
        """Return what was written down since a moment."""
        return [entry for entry in entries(self._diary.read_text()) if entry.moment > since]

    def story(self) -> Story:
        """Return what has become of the nodes by now."""
        story = Story(ORDER)
        for entry in self.entries():
            story.read(entry)
        return story

    def wait_until_active(self) -> None:
        """Wait until all nodes are active."""
        wait_until(lambda: self.story().all_active(), 30.0, "system that is active")

    def lose(self, name: str, chance: random.Random) -> Loss:
        """Kill or stop a node, have it come back, and wait until all are active."""
        process, is_kill = self.nodes[name], chance.random() < 0.5
        lost = self.write_down(name, "killed" if is_kill else "stopped")
        process.send_signal(signal.SIGKILL if is_kill else signal.SIGSTOP)
        time.sleep(chance.uniform(0.0, LONGEST_PAUSE if is_kill else LONGEST_STOP))
        if is_kill:
            self.start(name)
            wait_until(lambda: self._has("started", lost), 30.0, "start of " + name)
            back = next(each.moment for each in self.entries(lost) if each.what == "started")
        else:
            back = self.write_down(name, "continued")
            process.send_signal(signal.SIGCONT)
        time.sleep(0.2)  # one that was stopped shortly may be found silent yet
        self.wait_until_active()
        since = self.entries(lost)
        down = [one.moment for one in since if one.what == "deactivated" and one.node != name]
        up = [one.moment for one in since if one.what == "activated"]
        what = f"{name} {'killed' if is_kill else f'stopped for {back - lost:.1f} s'}"
        return Loss(what, min(down) - lost if down else None, max(up, default=back) - back)

    def _has(self, what: str, since: float) -> bool:
        return any(entry.what == what for entry in self.entries(since))


def run(soak: Soak) -> List[Check]:
    """Lose a node, again and again."""
    chance = random.Random(soak.seed)
    system = System(soak)
    system.wait_until_active()
    losses = []
    for _ in range(soak.times or TIMES):
        time.sleep(chance.uniform(0.0, 0.5))
        losses.append(system.lose(chance.choice(ORDER), chance))
    return report(losses, system.story())


def report(losses: List[Loss], story: Story) -> List[Check]:
    """Return the figures."""
    killed = [loss for loss in losses if loss.what.endswith("killed")]
    resumed = sorted(loss.resumed for loss in losses)
    worst = max(losses, key=lambda loss: loss.resumed).what
    checks = [
        reported("nodes killed", str(len(killed))),
        reported("nodes stopped", str(len(losses) - len(killed))),
        reported("active again after the return, median", f"{resumed[len(resumed) // 2]:.2f} s"),
        at_most(f"the longest ({worst})", round(resumed[-1], 3), ACTIVE_WITHIN, "s"),
    ]
    for kind, of_kind in (
        ("killed", killed),
        ("stopped", [loss for loss in losses if loss not in killed]),
    ):
        noticed = [loss.noticed for loss in of_kind if loss.noticed is not None]
        what = f"the others come down after one was {kind}, within"
        checks.append(at_most(what, round(max(noticed, default=0.0), 3), NOTICED_WITHIN, "s"))
    longest = round(story.longest, 3)
    checks += [
        none_of("activated while one before it is not configured", story.rash),
        at_most("stays active while one before it is lost", longest, NOTICED_WITHIN, "s"),
    ]
    return checks
