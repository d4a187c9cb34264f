# Pure: knows no ROS.
"""The request about a bag that is laid over what is shown."""

from typing import Any, Dict, NamedTuple, Optional

from topic_scope.protocol.checks import TIMES, RequestError, name_of, number_of

#: How much later or earlier a bag can be laid [s].
FARTHEST_S = 1e9
_KIND = "overlay"


class OverlayRequest(NamedTuple):
    """Lay a bag elsewhere; what is None stays as it is.

    :param name: of the bag
    :param offset: how much later than at its begin [s]
    :param begin: where its first message is without the offset [s] since the epoch
    :param trigger: the time at which it is to cross the level of the page's trigger for the first
        time, without the offset [s] since the epoch
    """

    name: str
    offset: Optional[float] = None
    begin: Optional[float] = None
    trigger: Optional[float] = None


def overlay_of(request: Dict[str, Any]) -> OverlayRequest:
    """Return which bag is to be laid where."""
    offset, begin, trigger = (
        None if request.get(key) is None else number_of(request, _KIND, key, *limits)
        for key, limits in (
            ("offset", (-FARTHEST_S, FARTHEST_S)),
            ("begin", TIMES),
            ("trigger", TIMES),
        )
    )
    if begin is not None and trigger is not None:
        raise RequestError("overlay: a bag has one begin, so begin and trigger exclude each other")
    return OverlayRequest(name_of(request, _KIND, "name"), offset, begin, trigger)
