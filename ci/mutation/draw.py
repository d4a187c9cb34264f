"""The mutants of modules, and a draw of some of them."""

import hashlib
from typing import Dict, Iterable, Iterator, List, NamedTuple

from .changes import Source


class Mutant(NamedTuple):
    """A module with one change."""

    #: Its path below src.
    module: str
    #: Where it differs, from 1 on.
    line: int
    before: str
    after: str
    #: Of the whole module.
    text: str
    #: What it is called from run to run, whatever is written above and below it.
    key: str

    def described(self) -> str:
        """Return where it is and what was changed, in one line."""
        return f"src/{self.module}:{self.line}: {self.before} → {self.after}"


def mutants_of(module: str, text: str) -> Iterator[Mutant]:
    """Return all mutants of a module.

    :param module: its path below src
    """
    source = Source(text)
    seen: Dict[str, int] = {}
    for change in source.changes():
        line, before, after = source.lines_of(change)
        name = f"{module}: {before} → {after}"
        seen[name] = seen.get(name, 0) + 1
        yield Mutant(module, line, before, after, source.changed(change), f"{name} {seen[name]}")


def drawn(found: Iterable[Mutant], count: int, seed: int) -> List[Mutant]:
    """Draw some mutants; whether one is among them hardly depends on which others there are."""

    def lot(mutant: Mutant) -> bytes:
        return hashlib.sha256(f"{seed} {mutant.key}".encode()).digest()

    return sorted(found, key=lot)[:count]
