"""Context of a long run, and the pair of nodes at 1 kHz that several runs disturb."""

import contextlib
import subprocess
from typing import Dict, Iterator, List, NamedTuple

from ..benchmark.peer_programs import executable
from ..benchmark.processes import Session
from ..benchmark.tcpros import Node
from .checks import Check, at_most, reported
from .control import Control
from .usage import Usage, not_grown, settled_usage
from .watching import ANSWER, SIGNAL, Watch

RATE = 1000.0
#: Longest silence for a subscriber that is not disturbed [s].
UNDISTURBED = 0.1


class Soak(NamedTuple):
    """The surroundings of a run."""

    session: Session
    #: how long the recording takes [s]
    seconds: float
    #: how often nodes are killed or interrupted; 0 for each run's own number
    times: int
    #: seed of everything random
    seed: int

    def start(self, name: str, *arguments: str) -> "subprocess.Popen[bytes]":
        """Start one of the nodes of basic_comms.

        :param arguments: parameters and remappings
        """
        return self.session.start(executable("basic_comms", name, *arguments))


class Pair:
    """Generator and process node at 1 kHz, with a good subscriber to both."""

    def __init__(self, soak: Soak, node: Node, arguments: List[str]) -> None:
        self._session = soak.session
        self.process = soak.start("process.py")
        soak.session.wait_for("/process")
        self.signal = Watch(node, "/signal", SIGNAL, RATE)
        self.answers = Watch(node, "/proc_signal", ANSWER)
        self.generator = soak.start("signal_generator.py", f"_rate:={RATE:g}", *arguments)
        soak.session.wait_for("/signal_generator")
        self.pids = {"signal_generator": self.generator.pid, "process": self.process.pid}

    def begin(self) -> None:
        """Begin to observe."""
        self._before = self.usage()
        self.signal.restart()
        self.answers.restart()
        self._control = Control(self._session)

    def usage(self) -> Dict[str, Usage]:
        """Return what each node uses now."""
        return {name: settled_usage(pid) for name, pid in self.pids.items()}

    def silences(self) -> List[Check]:
        """Return the silences since the beginning."""
        return [
            reported("silences of /signal", str(self.signal.arrivals)),
            reported("silences of /proc_signal", str(self.answers.arrivals)),
            reported("pauses of a loop that only sleeps", self._control.stop()),
            at_most("missing at a good subscriber", self.signal.continuity.missing, 0),
        ]

    def end(self) -> List[Check]:
        """Check that the good subscriber received everything in time, and that nothing grew."""
        checks = self.silences()
        for watch in (self.signal, self.answers):
            longest = round(1e3 * watch.arrivals.longest_gap, 1)
            checks.append(at_most(f"longest of {watch.topic}", longest, 1e3 * UNDISTURBED, "ms"))
        for name, after in self.usage().items():
            checks += not_grown(name, [self._before[name], after])
        return checks


@contextlib.contextmanager
def signal_pair(soak: Soak, *arguments: str) -> Iterator[Pair]:
    """Run the pair for the duration of the context.

    :param arguments: of the generator
    """
    with soak.session.node() as node:
        pair = Pair(soak, node, list(arguments))
        yield pair
        soak.session.stop(pair.generator, pair.process)
