"""Takes all measurements in turns, until more of them would say little."""

import contextlib
import gc
import math
import subprocess
import time
from typing import Callable, Dict, Iterable, List, Optional, Set

from . import machine
from .context import Bench, Figures
from .goals import GOALS
from .measurements import Measurement
from .results import Results

#: Of the main rows, no repeat of what is measured afresh begins that would end later, s.
LIMIT_S = 570.0
#: How often that is repeated at most.
REPEATS = 12
#: How long those that stand ready take turns at most, for each measurement, s.
ROW_S = 45.0
#: Turns of each of them that are taken all the same: of so few, the interval is nearly from the
#: least to the greatest.
LEAST_ROUNDS = 6
#: Turns of each of them until all are started anew: what a process got at its start, such as where
#: its memory lies, makes all its turns resemble each other.
ROUNDS = 2

#: What a measurement may fail of, without being the end of all others.
FAULTS = (LookupError, OSError, RuntimeError, ValueError, subprocess.SubprocessError)


class Turns:
    """Measures, and puts what it comes to into results.

    :param wanted: what to measure
    :param bench: given to each measurement
    :param results: where to
    :param most: turns of each at most, if not as many as there is time for
    :param say: is told what is going on
    """

    def __init__(
        self,
        wanted: List[Measurement],
        bench: Bench,
        results: Results,
        most: Optional[int],
        say: Callable[[str], None],
    ) -> None:
        self._wanted = wanted
        self._bench = bench
        self._results = results
        self._most = most
        self._say = say

    def take_all(self, limit: Optional[float] = None) -> None:
        """Take all turns: first of those that stand ready, then of those that start afresh.

        :param limit: how long that may take, s; as long as it takes unless given
        """
        began = time.monotonic()
        for measurement in self._wanted:
            if measurement.stand_ready is not None:
                self._take_standing(measurement)
        afresh = [one for one in self._wanted if one.measure is not None]
        end = math.inf if limit is None else began + limit
        # Apart, as a repeat of all others is taken to be as long as their first one.
        self._take_afresh([one for one in afresh if one.repeats == 1], end)
        self._take_afresh([one for one in afresh if one.repeats > 1], end)

    def _take_standing(self, measurement: Measurement) -> None:
        """Take turns of those that stand ready, who are started anew now and then."""
        began, number = time.monotonic(), 0
        wanted = self._subjects(measurement)
        while wanted and number != self._most:
            if number >= LEAST_ROUNDS and time.monotonic() - began > ROW_S:
                break
            until = number + ROUNDS if self._most is None else min(number + ROUNDS, self._most)
            wanted = self._take_rounds(measurement, wanted, range(number, until))
            number = until

    def _take_rounds(
        self, measurement: Measurement, subjects: List[str], numbers: Iterable[int]
    ) -> List[str]:
        """Have all subjects up, of which one at a time goes on for a short turn.

        :param numbers: of the rounds that are taken
        :returns: the subjects of which more turns would say more
        """
        assert measurement.stand_ready is not None
        ready: Dict[str, Callable[[], Figures]] = {}
        with contextlib.ExitStack() as stack:
            for subject in subjects:
                self._say(f"{measurement.name}: starting {subject}")
                try:
                    one = measurement.stand_ready(self._bench, subject)
                    ready[subject] = stack.enter_context(one)
                except FAULTS as error:
                    self._fail(f"{measurement.name}, {subject}", error)
            for number in numbers:
                for subject in rotated(list(ready), number):
                    if not self._take(measurement.name, subject, number, ready[subject]):
                        del ready[subject]
                wanted = self._unsure(measurement, list(ready))
                ready = {subject: ready[subject] for subject in ready if subject in wanted}
        return list(ready)

    def _take_afresh(self, wanted: List[Measurement], end: float) -> None:
        latest = time.monotonic()
        for repeat in range(REPEATS if self._most is None else self._most):
            now = time.monotonic()
            if repeat and now + (now - latest) > end:
                self._say(f"that took long: stopping after {repeat} repeats")
                return
            latest = now
            for measurement in wanted:
                disturbed = self._results.disturbed[measurement.name]
                if repeat < measurement.repeats + disturbed and not self._is_settled(measurement):
                    self._repeat(measurement, repeat)

    def _repeat(self, measurement: Measurement, repeat: int) -> None:
        assert measurement.measure is not None
        for subject in rotated(self._subjects(measurement), repeat):
            has_turn = self._results.turns(measurement.name, subject) > 0
            if subject in measurement.slow and (self._bench.quick or has_turn):
                continue
            if repeat == 0 and measurement.warm_up:
                self._say(f"{measurement.name}, {subject}, warm-up")
                with contextlib.suppress(*FAULTS):
                    measurement.measure(self._bench._replace(quick=True), subject)
            measure, bench = measurement.measure, self._bench
            self._take(measurement.name, subject, repeat, lambda: measure(bench, subject))

    def _subjects(self, measurement: Measurement) -> List[str]:
        left_out = self._bench.peers.left_out
        return [subject for subject in measurement.subjects if subject not in left_out]

    def _take(self, name: str, subject: str, turn: int, measure: Callable[[], Figures]) -> bool:
        """Take a turn; a failure is told of and ends nothing else.

        Nothing comes of a turn in which the host took much of the processors' time.

        :returns: whether it did not fail
        """
        what = f"{name}, {subject}"
        self._say(f"{what}, turn {turn + 1}")
        steal = machine.Steal()
        try:
            figures = measure()
        except FAULTS as error:
            self._fail(what, error)
            return False
        share = steal.share()
        self._results.note_conditions(name, subject, turn, share)
        if share <= machine.STOLEN:
            self._results.add(name, subject, turn, figures)
        else:
            self._results.disturbed[name] += 1
            self._say(f"{what}: left out, as the host took {100.0 * share:.1f} % of the time")
        gc.collect()
        return True

    def _fail(self, what: str, error: Exception) -> None:
        self._results.failures.append(f"{what}: {error!r}")
        self._say(self._results.failures[-1])

    def _is_settled(self, measurement: Measurement) -> bool:
        """Tell whether more turns of a measurement would say little more of any of its goals."""
        verdicts = [
            goal.judge(self._results) for goal in GOALS if goal.measurement == measurement.name
        ]
        judged = [verdict for verdict in verdicts if verdict is not None]
        return bool(judged) and all(verdict.is_settled for verdict in judged)

    def _unsure(self, measurement: Measurement, subjects: List[str]) -> Set[str]:
        """Return who had few turns so far, or of whom more turns would say more of some goal."""
        found = {
            subject
            for subject in subjects
            if self._results.turns(measurement.name, subject) < LEAST_ROUNDS
        }
        for goal in GOALS:
            if goal.measurement == measurement.name:
                verdict = goal.judge(self._results)
                if verdict is not None and not verdict.is_settled:
                    found.update(goal.subjects)
        return found


def rotated(subjects: List[str], turn: int) -> List[str]:
    """Return the subjects, another one first in each turn."""
    first = turn % max(1, len(subjects))
    return subjects[first:] + subjects[:first]
