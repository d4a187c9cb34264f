"""What every measurement is given."""

from typing import Dict, NamedTuple

from .peer_programs import Peers
from .processes import Session

#: names and values of what one measurement of one stack came to
Figures = Dict[str, float]


class Bench(NamedTuple):
    """The surroundings of a measurement."""

    session: Session
    peers: Peers
    #: whether it is to be short
    quick: bool

    def seconds(self, full: float, quick: float) -> float:
        """Choose how long to measure.

        :param full: s, where time matters less than the figure
        :param quick: s, where it is the other way round
        """
        return quick if self.quick else full
