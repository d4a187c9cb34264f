"""Context of a long run."""

from typing import NamedTuple

from ..benchmark.processes import Session


class Soak(NamedTuple):
    """Context of a run."""

    session: Session
    #: duration of record, board, scope, images and bridge [s]
    seconds: float
    #: how often nodes are killed or stopped
    times: int
    #: seed of everything random
    seed: int
