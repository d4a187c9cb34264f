"""Finder of coursework 1 (signal generator and process node) in each package of a batch run."""

from typing import List, Optional, Sequence

from pid_control.signal_judging.scenarios import SCENARIO_METRICS
from pid_control.signal_runner.coursework import has_coursework
from pid_control.verdicts.limits import Figures


class CourseworkFinder:
    """Finder of the packages with a first coursework; a :class:`.SubjectFinder`.

    :param words: launch file of each package, and its arguments; empty to find it
    """

    subject = "package"
    figures: Figures = SCENARIO_METRICS

    def __init__(self, words: Sequence[str]) -> None:
        self._words = list(words)

    def is_in(self, package: str) -> bool:
        """Return True if a package looks like the coursework."""
        return has_coursework(package)

    def is_built_by(self, package: str) -> bool:
        """Return False: the sources of built programs are in the package too."""
        return False

    def words(self, package: str, workspace: Optional[str]) -> List[str]:
        """Return the folder of the package, and the launch file."""
        return [package, *self._words]

    def hint(self, folder: str) -> str:
        """Return an empty text: without a package.xml, nothing can be started."""
        return ""
