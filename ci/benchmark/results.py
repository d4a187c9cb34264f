"""What the measurements came to, repeat by repeat."""

import collections
import math
import statistics
from typing import Any, Counter, Dict, List, Sequence, Tuple

from . import machine
from .context import Figures


def table(rows: List[List[str]]) -> str:
    """Return rows as a table whose first row is the head, in Markdown."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = [
        f"| {' | '.join(cell.ljust(width) for cell, width in zip(row, widths))} |" for row in rows
    ]
    lines.insert(1, f"|{'|'.join('-' * (width + 2) for width in widths)}|")
    return "\n".join(lines)


class Results:
    """Figures by measurement, subject and repeat."""

    def __init__(self) -> None:
        self._runs: Dict[Tuple[str, str], Dict[int, Figures]] = {}
        #: how it was on the machine in each turn, those that are left out too
        self.conditions: List[Dict[str, Any]] = []
        #: turns left out as the host took too much of their time, by measurement
        self.disturbed: Counter[str] = collections.Counter()
        #: "measurement, subject: reason" of what went wrong
        self.failures: List[str] = []

    def add(self, measurement: str, subject: str, repeat: int, figures: Figures) -> None:
        """Keep the figures of one run."""
        self._runs.setdefault((measurement, subject), {})[repeat] = figures

    def note_conditions(self, measurement: str, subject: str, repeat: int, stolen: float) -> None:
        """Keep what else went on in a turn.

        :param stolen: the share of the processors' time that the host took
        """
        self.conditions.append(
            {
                "measurement": measurement,
                "subject": subject,
                "repeat": repeat,
                "stolen": stolen,
                "load": machine.load(),
            }
        )

    def turns(self, measurement: str, subject: str) -> int:
        """Return how many turns there are figures of."""
        return len(self._runs.get((measurement, subject), {}))

    def subjects(self) -> List[Tuple[str, str]]:
        """Return (measurement, subject) of all that was measured."""
        return list(self._runs)

    def values(self, measurement: str, subject: str, figure: str) -> List[float]:
        """Return a figure of each repeat; none where it was not measured."""
        runs = self._runs.get((measurement, subject), {})
        return [figures[figure] for figures in runs.values()]

    def median(self, measurement: str, subject: str, figure: str) -> float:
        """Return the median of a figure over the repeats.

        :raises LookupError: if it was not measured
        """
        values = self.values(measurement, subject, figure)
        if not values:
            raise LookupError(f"{measurement} of {subject} was not measured")
        return statistics.median(values)

    def ratios(self, measurement: str, subject: str, peer: str, figure: str) -> List[float]:
        """Return the ratio of a figure to that of a peer, of each repeat that has both.

        Where the peer was measured in other repeats, the ratio of the medians.

        :raises LookupError: if either was not measured
        """
        return self.ratios_to_sum(measurement, subject, [peer], figure)

    def ratios_to_sum(
        self, measurement: str, subject: str, peers: Sequence[str], figure: str
    ) -> List[float]:
        """Return the same against the sum of some peers, of each repeat that has them all."""
        names = [subject, *peers]
        runs = [self._runs.get((measurement, name), {}) for name in names]
        rows = [
            [figures[repeat][figure] for figures in runs]
            for repeat in sorted(set(runs[0]).intersection(*runs[1:]))
        ] or [[self.median(measurement, name, figure) for name in names]]
        return [ours / sum(theirs) if sum(theirs) else math.inf for ours, *theirs in rows]

    def medians(self, measurement: str, subject: str) -> Figures:
        """Return the median of each figure."""
        runs = self._runs[measurement, subject]
        names = next(iter(runs.values()))
        return {name: self.median(measurement, subject, name) for name in names}

    def as_json(self) -> List[Dict[str, Any]]:
        """Return every figure of every repeat."""
        return [
            {"measurement": measurement, "subject": subject, "repeat": repeat, "figures": figures}
            for (measurement, subject), runs in self._runs.items()
            for repeat, figures in runs.items()
        ]
