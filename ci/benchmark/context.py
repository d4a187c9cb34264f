"""Context of a measurement."""

from typing import Dict, NamedTuple

from .processes import Session

#: Figures of one turn of one subject, by name.
Figures = Dict[str, float]


class Bench(NamedTuple):
    """Context of a measurement."""

    session: Session
    is_quick: bool = False
    #: reason for each omitted peer, by its name
    left_out: Dict[str, str] = {}

    def seconds(self, full: float, quick: float) -> float:
        """Return the duration of a measurement, which may have to be quick [s]."""
        return quick if self.is_quick else full
