"""What became of a draw of mutants."""

import json
import pathlib
from typing import Dict, List, Sequence

from . import pure_modules as mutants
from .draw import Mutant


class Verdicts:
    """Keeps it in a folder, for its reader and for the run that goes on with it.

    :param place: the folder
    :param asked: the mutants drawn
    """

    def __init__(self, place: pathlib.Path, asked: Sequence[Mutant]) -> None:
        self._text, self._state = place / "report.txt", place / "judged.json"
        self._asked = asked
        #: What killed a mutant, by its key; empty if it survived.
        self._killers: Dict[str, str] = {}
        if self._state.exists():
            self._killers = json.loads(self._state.read_text("utf-8"))

    def forget_survivors(self) -> None:
        """Have them judged again, by the tests that have been added."""
        self._killers = {key: killer for key, killer in self._killers.items() if killer}

    def waiting(self) -> List[Mutant]:
        """Return what has not been judged."""
        return [mutant for mutant in self._asked if mutant.key not in self._killers]

    def add(self, mutant: Mutant, killer: str, left_out: Sequence[str]) -> None:
        """Write what was found of a mutant.

        :param killer: the test that noticed it; empty if none did
        :param left_out: the tests that fail without a mutant, and why
        """
        self._killers[mutant.key] = killer
        self._state.write_text(json.dumps(self._killers, indent=1), "utf-8")
        killed = [f"{one.described()}\n    {self._killers[one.key]}" for one in self._killed()]
        failing = [f"left out, as it fails without a mutant: {test}" for test in left_out]
        text = "\n".join([*failing, self.summary(), "killed:", *killed])
        self._text.write_text(text + "\n", "utf-8")

    def share(self) -> float:
        """Return how many of those judged were killed, %."""
        killed = self._killed()
        return mutants.percent(len(killed), len(killed) + len(self._survivors()))

    def summary(self) -> str:
        """Return the survivors, and the figures."""
        killed, survivors = self._killed(), self._survivors()
        figures = f"{len(killed)} of {len(killed) + len(survivors)} killed, {self.share():.1f} %"
        lines = [f"survived: {mutant.described()}" for mutant in survivors]
        wanted = f"wanted are {mutants.GOAL:.0f} %; {len(self._asked)} were drawn"
        return "\n".join([*lines, f"{figures}; {wanted}"])

    def _killed(self) -> List[Mutant]:
        return [mutant for mutant in self._asked if self._killers.get(mutant.key)]

    def _survivors(self) -> List[Mutant]:
        return [mutant for mutant in self._asked if self._killers.get(mutant.key) == ""]
