# Pure: knows no ROS.
"""Request to shift an overlaid bag."""

from typing import Any, Dict, NamedTuple, Optional

from topic_scope.protocol.checks import TIMES, RequestError, name_of, number_of

#: Range of the shift of a bag [s].
FARTHEST_S = 1e9
_KIND = "overlay"


class OverlayRequest(NamedTuple):
    """Shift an overlaid bag; None leaves a value unchanged.

    :param name: of the bag
    :param offset: shift to later times, relative to ``begin`` [s]
    :param begin: time of its first message without the offset [s] since the epoch
    :param trigger: time at which its first crossing of the page's trigger level is placed,
        without the offset [s] since the epoch
    """

    name: str
    offset: Optional[float] = None
    begin: Optional[float] = None
    trigger: Optional[float] = None


def overlay_of(request: Dict[str, Any]) -> OverlayRequest:
    """Return the bag to shift, and its new position."""
    offset, begin, trigger = (
        None if request.get(key) is None else number_of(request, _KIND, key, *limits)
        for key, limits in (
            ("offset", (-FARTHEST_S, FARTHEST_S)),
            ("begin", TIMES),
            ("trigger", TIMES),
        )
    )
    if begin is not None and trigger is not None:
        raise RequestError("overlay: give begin or trigger, not both")
    return OverlayRequest(name_of(request, _KIND, "name"), offset, begin, trigger)
