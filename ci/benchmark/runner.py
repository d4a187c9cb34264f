"""Runner of the benchmark: takes turns of all subjects of a row, in rounds."""

import contextlib
import gc
import math
import subprocess
import time
from typing import Callable, Dict, Iterator, List, Optional

from . import machine
from .context import Bench
from .measurements import Measurement, Turn
from .results import Results

#: Errors that end the turns of one subject only.
FAULTS = (LookupError, OSError, RuntimeError, ValueError, subprocess.SubprocessError)


class Runner:
    """Measures rows, and adds their figures to the results.

    :param bench: context of each measurement
    :param results: receives the figures
    :param most: highest number of rounds of each row; its own unless given
    :param say: reports progress
    """

    def __init__(
        self, bench: Bench, results: Results, most: Optional[int], say: Callable[[str], None]
    ) -> None:
        self._bench = bench
        self._results = results
        self._most = most
        self._say = say

    def run(self, measurements: List[Measurement], deadline: float = math.inf) -> None:
        """Measure rows, one after the other.

        :param deadline: monotonic time after which only first rounds begin [s]
        """
        for one in measurements:
            rounds = min(one.rounds, self._most or one.rounds)
            for first in range(0, rounds, one.rounds_per_start):
                if first == 0 or time.monotonic() < deadline:
                    numbers = range(first, min(first + one.rounds_per_start, rounds))
                    self._take_rounds(one, list(numbers), deadline)

    def _take_rounds(self, one: Measurement, numbers: List[int], deadline: float) -> None:
        """Start all subjects and take their turns, each round starting with another subject."""
        ready: Dict[str, Turn] = {}
        with contextlib.ExitStack() as stack:
            for subject in one.subjects:
                if subject.split(",")[0] not in self._bench.left_out:
                    with self._reported(f"{one.name}, {subject}"):
                        self._say(f"{one.name}: starting {subject}")
                        ready[subject] = stack.enter_context(one.prepare(self._bench, subject))
            for number in numbers:
                if number > numbers[0] and time.monotonic() > deadline:
                    self._say(f"{one.name}: ends after {number} rounds, as time is up")
                    return
                first = number % max(1, len(ready))
                for subject in (list(ready) * 2)[first : first + len(ready)]:
                    turn = ready.pop(subject)
                    with self._reported(f"{one.name}, {subject}"):
                        self._take_turn(one.name, subject, number, turn)
                        ready[subject] = turn
                ready = {name: ready[name] for name in one.subjects if name in ready}

    def _take_turn(self, name: str, subject: str, number: int, turn: Turn) -> None:
        """Take a turn; repeat it once if the host took much of the processors' time."""
        for _ in range(2):
            self._say(f"{name}, {subject}, round {number + 1}")
            steal = machine.Steal()
            figures = turn()
            gc.collect()
            if steal.share() <= machine.STOLEN:
                self._results.add(name, subject, number, figures)
                return
            self._results.disturbed[name] += 1

    @contextlib.contextmanager
    def _reported(self, what: str) -> Iterator[None]:
        """Add an error to the failures."""
        try:
            yield
        except FAULTS as error:
            self._results.failures.append(f"{what}: {error!r}")
            self._say(self._results.failures[-1])
