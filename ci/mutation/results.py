"""Results of mutants: survivors, and rates by package and by type of fault."""

import json
import math
import pathlib
import re
from typing import Dict, List, Sequence, Tuple

from .mutants import SOURCES, Mutant

#: Smallest share of mutants that must be killed [%].
GOAL = 90.0
#: Survivors that are equivalent to the original, and why.
EQUIVALENT = pathlib.Path(__file__).with_name("survivors.md")
ROW = re.compile(r"^- `src/(\S+)`: (`.*` → `.*`): ", re.MULTILINE)


def figures(killed: Sequence[bool]) -> str:
    """Return the number of killed mutants as text, with Wilson's 95 % interval."""
    made, z = len(killed), 1.96
    share = sum(killed) / made if made else 1.0
    middle = (share * made + z * z / 2) / (made + z * z)
    half = z * math.sqrt(share * (1 - share) * made + z * z / 4) / (made + z * z)
    bounds = f"95 %: {100 * (middle - half):.0f} to {100 * (middle + half):.0f}"
    return f"{sum(killed)} of {made} killed, {100 * share:.1f} % ({bounds})"


class Results:
    """Results in a folder, for the reader and for a resumed run.

    :param place: the folder
    :param asked: the mutants drawn
    """

    def __init__(self, place: pathlib.Path, asked: Sequence[Mutant]) -> None:
        self._text, self._state = place / "report.txt", place / "results.json"
        self._asked = asked
        #: The test that killed a mutant, and why, by the mutant's key; empty if it survived.
        self._killers: Dict[str, str] = {}
        if self._state.exists():
            self._killers = json.loads(self._state.read_text("utf-8"))

    def waiting(self) -> List[Mutant]:
        """Return the mutants that no test has killed yet, survivors last."""
        waiting = [mutant for mutant in self._asked if not self._killers.get(mutant.key)]
        return sorted(waiting, key=lambda mutant: mutant.key in self._killers)

    def add(self, mutant: Mutant, killer: str, left_out: Sequence[str]) -> None:
        """Store the result of a mutant.

        :param killer: the test that failed; empty if none did
        :param left_out: the tests that fail without a mutant, and why
        """
        self._killers[mutant.key] = killer
        self._state.write_text(json.dumps(self._killers, indent=1), "utf-8")
        failing = [f"left out, as it fails without a mutant: {test}" for test in left_out]
        killed = [f"{one}\n    {by}" for one, by in self._tested() if by]
        self._text.write_text(
            "\n".join([*failing, self.summary(), "killed:", *killed, ""]), "utf-8"
        )

    def _tested(self) -> List[Tuple[Mutant, str]]:
        found = self._killers
        return [(one, found[one.key]) for one in self._asked if one.key in found]

    def _counted(self) -> List[Tuple[Mutant, bool]]:
        """Return the tested mutants and whether they were killed, without known equivalents."""
        same = ROW.findall(EQUIVALENT.read_text("utf-8"))
        tested = self._tested()
        return [(one, by != "") for one, by in tested if by or (one.module, one.change) not in same]

    def is_good(self) -> bool:
        killed = [is_killed for _, is_killed in self._counted()]
        return 100 * sum(killed) >= GOAL * len(killed)

    def outdated(self) -> List[str]:
        """Return the rows of known equivalents that a test kills, or with a changed line."""
        killed = {(one.module, one.change) for one, by in self._tested() if by}
        found = []
        for module, change in ROW.findall(EQUIVALENT.read_text("utf-8")):
            path, line = SOURCES / module, change[1:].split("` → `")[0]
            text = " ".join(path.read_text("utf-8").split()) if path.is_file() else ""
            if (module, change) in killed or line not in text:
                found.append(f"in survivors.md, but no survivor: src/{module}: {change}")
        return found

    def summary(self) -> str:
        """Return the survivors, the rates by package and by type, and the total rate."""
        counted = self._counted()
        groups: Dict[str, List[bool]] = {}
        for one, is_killed in counted:
            page = ", page" if one.module.endswith(".js") else ""
            groups.setdefault(f"package {one.module.split('/')[0]}{page}", []).append(is_killed)
            groups.setdefault(f"kind {one.kind}", []).append(is_killed)
        rates = [f"{name}: {figures(killed)}" for name, killed in sorted(groups.items())]
        survived = sorted(f"survived: {one}" for one, is_killed in counted if not is_killed)
        all_of_it = figures([is_killed for _, is_killed in counted])
        same = f"{len(self._tested()) - len(counted)} more do the same by survivors.md"
        last = f"{all_of_it}; wanted are {GOAL:.0f} %; {len(self._asked)} were drawn; {same}"
        return "\n".join([*self.outdated(), *survived, *rates, last])
