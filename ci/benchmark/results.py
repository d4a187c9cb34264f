"""Figures of all turns, and their comparison with a peer's in the same round."""

import collections
from typing import Any, Counter, Dict, List, Sequence, Tuple

from .analysis import Estimate, estimate
from .context import Figures


class Results:
    """Figures by measurement, subject and round."""

    def __init__(self) -> None:
        self._turns: Dict[Tuple[str, str], Dict[int, Figures]] = {}
        #: omitted turns, because the host took too much of their time, by measurement
        self.disturbed: Counter[str] = collections.Counter()
        #: "measurement, subject: reason"
        self.failures: List[str] = []

    def add(self, measurement: str, subject: str, number: int, figures: Figures) -> None:
        """Add the figures of a turn."""
        self._turns.setdefault((measurement, subject), {})[number] = figures

    def estimate(
        self, measurement: str, subject: str, figure: str, peers: Sequence[str] = ()
    ) -> Estimate:
        """Return a figure, or its ratio to the sum of the peers' figures of the same rounds.

        :raises LookupError: if the subject and the peers do not share a round
        """
        turns = [self._turns.get((measurement, name), {}) for name in (subject, *peers)]
        rounds = sorted(set(turns[0]).intersection(*turns[1:]))
        if not rounds:
            raise LookupError(f"{measurement} of {subject} was not measured")
        rows = [[one[number][figure] for one in turns] for number in rounds]
        return estimate([ours / sum(theirs) if theirs else ours for ours, *theirs in rows])

    def estimates(self) -> List[Tuple[str, str, str, Estimate]]:
        """Return measurement, subject and name of each figure, and the figure."""
        return [
            (measurement, subject, figure, self.estimate(measurement, subject, figure))
            for (measurement, subject), turns in self._turns.items()
            for figure in next(iter(turns.values()))
        ]

    def as_json(self) -> List[Dict[str, Any]]:
        """Return every figure of every turn."""
        return [
            {"measurement": measurement, "subject": subject, "round": number, "figures": figures}
            for (measurement, subject), turns in self._turns.items()
            for number, figures in turns.items()
        ]
