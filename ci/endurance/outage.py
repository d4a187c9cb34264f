"""What an outage of the network cost, from what was seen on both sides of it."""

import re
from typing import Dict, List, NamedTuple, Sequence

from ..benchmark.analysis import Sample
from .streams import Continuity

_LOSS = re.compile(r"(\S+): subscriber (\S+) (?:does not keep|keeps) up.* (\d+) in all")
_LATE = re.compile(r"in time again; (\d+) were late, by up to ([0-9.]+) s")


class Outage(NamedTuple):
    """How a stream got over an outage."""

    #: samples that were made between the first one seen there and the last
    made: int
    #: those of them that never came
    lost: int
    #: longest silence, s
    silence: float
    #: how late the latest sample was, s
    lateness: float


def outage(period: float, there: Sequence[Sample]) -> Outage:
    """Look at what crossed the network.

    :param period: from one sample to the next, s
    :param there: moment of arrival on the other side and time_x of each sample
    """
    continuity = Continuity(period)
    for sample in there:
        continuity.add(sample.value)
    silence = max(later.moment - earlier.moment for earlier, later in zip(there, there[1:]))
    lags = [sample.moment - sample.value for sample in there]
    made = len(there) + continuity.missing
    return Outage(made, continuity.missing, silence, max(lags) - min(lags))


def counted_losses(log: str) -> Dict[str, int]:
    """Return how many messages publishers say that they lost, by "topic subscriber"."""
    losses: Dict[str, int] = {}
    for topic, subscriber, total in _LOSS.findall(log):
        key = f"{topic} {subscriber}"
        losses[key] = max(losses.get(key, 0), int(total))
    return losses


def reported_lateness(log: str) -> List[float]:
    """Return how late samples were, as a node says after each outage, s."""
    return [float(worst) for _, worst in _LATE.findall(log)]
