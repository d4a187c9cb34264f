"""Context of a measurement."""

from typing import Dict, NamedTuple

from .processes import Session

#: Names and values of what one turn of one subject came to.
Figures = Dict[str, float]


class Bench(NamedTuple):
    """The surroundings of a measurement."""

    session: Session
    is_quick: bool = False
    #: reason for each peer that is left out, by its name
    left_out: Dict[str, str] = {}

    def seconds(self, full: float, quick: float) -> float:
        """Return how long to measure, depending on whether it has to be quick [s]."""
        return quick if self.is_quick else full
