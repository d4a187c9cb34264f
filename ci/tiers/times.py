"""Times of earlier runs' steps, stored in build/, to estimate the next run."""

import json
import pathlib
import statistics
from typing import Dict, List, Optional, Sequence

from .workspace import WORKSPACE

FILE = WORKSPACE / "build" / "test-times.json"
#: Number of runs stored for each step.
KEPT = 5
#: Factor of the usual processor time above which a step is reported, if the difference is also
#: above DIFFERENCE_S [s]: a busy machine causes smaller ones.
GROWTH = 1.5
DIFFERENCE_S = 3.0


class Times:
    """Wall and processor time of each step in its last good runs [s].

    :param path: path of the file, FILE by default
    """

    def __init__(self, path: Optional[pathlib.Path] = None) -> None:
        self._path = path = path or FILE
        try:
            self._known: Dict[str, List[List[float]]] = json.loads(path.read_text("utf-8"))
        except (OSError, ValueError):
            self._known = {}

    def wall(self, step: str, unknown: float = 0.0) -> float:
        """Return the usual wall time of a step, or a default for an unknown step [s]."""
        return self._usual(step, 0, unknown)

    def cpu(self, step: str) -> float:
        """Return the usual processor time of a step, 0 for an unknown step [s]."""
        return self._usual(step, 1, 0.0)

    def _usual(self, step: str, column: int, unknown: float) -> float:
        runs = self._known.get(step)
        return statistics.median(run[column] for run in runs) if runs else unknown

    def knows(self, step: str) -> bool:
        """Return whether a step has been run before."""
        return step in self._known

    def has_grown(self, step: str, cpu: float) -> bool:
        """Return whether a step took far more processor time than usual.

        :param cpu: its processor time [s]
        """
        usual = self.cpu(step)
        return self.knows(step) and cpu > GROWTH * usual and cpu - usual > DIFFERENCE_S

    def add(self, step: str, wall: float, cpu: float) -> None:
        """Add the times of a passed run of a step [s]."""
        runs = self._known.setdefault(step, [])
        runs.append([round(wall, 2), round(cpu, 2)])
        del runs[:-KEPT]

    def save(self) -> None:
        """Write the file."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        new = self._path.with_suffix(".new")
        new.write_text(json.dumps(self._known, indent=0, sort_keys=True), "utf-8")
        new.replace(self._path)


def estimate(durations: Sequence[float], lanes: int) -> float:
    """Return the estimated time of steps in this order, several at a time [s].

    :param durations: durations of the steps [s]
    :param lanes: number of steps that run at a time
    """
    ends = [0.0] * lanes
    for duration in durations:
        soonest = min(range(lanes), key=ends.__getitem__)
        ends[soonest] += duration
    return max(ends)
