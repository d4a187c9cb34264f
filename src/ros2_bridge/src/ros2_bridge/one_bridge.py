"""No second bridge between the same master and the same domain."""

import contextlib

from nodekit import CallError
from nodekit.life.server import Server
from nodekit.process.ending import end
from nodekit.transport.service_call import ServiceCall
from ros2_bridge.ros1 import Trigger
from ros2_bridge.ros2_side import domain


def marker() -> str:
    """Return the service that one bridge between this master and this domain offers."""
    return f"/ros2_bridge_of_domain_{domain()}"


def refuse_second() -> None:
    """End where there is such a bridge already: two would answer each other for ever."""
    with contextlib.suppress(CallError):
        call = ServiceCall(1.0)
        Server(marker(), Trigger).look(call)
        end(f"bridge: {call.said.get('callerid')} joins this master and this domain already")
