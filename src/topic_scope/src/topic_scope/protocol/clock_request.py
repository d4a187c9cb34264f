# Pure: knows no ROS.
"""Request to choose the clock of a topic's timestamps."""

from typing import Any, Dict, NamedTuple

from topic_scope.protocol.checks import name_of


class ClockRequest(NamedTuple):
    """Request to use the clock of another topic.

    :param topic: the topic whose samples are placed
    :param leader: the topic whose clock is used; empty to estimate the clock
    """

    topic: str
    leader: str


def clock_request_of(request: Dict[str, Any]) -> ClockRequest:
    """Return the requested clock of a topic."""
    leader = "" if request.get("leader") == "" else name_of(request, "clock", "leader")
    return ClockRequest(name_of(request, "clock", "topic"), leader)
