"""No second bridge between the same master and the same domain."""

import contextlib
import socket
import uuid

import rosgraph

from nodekit import CallError
from nodekit.life.server import Server
from nodekit.process.ending import end
from nodekit.transport.service_call import ServiceCall
from ros2_bridge.ros1 import Trigger
from ros2_bridge.ros2_side import domain

#: Has a name that one process of a machine can have at a time, until its end, whatever that is.
_held = socket.socket(socket.AF_UNIX)


def marker() -> str:
    """Return the service that one bridge between this master and this domain offers."""
    return f"/ros2_bridge_of_domain_{domain()}"


def refuse_second() -> None:
    """End where there is such a bridge already: two would answer each other for ever."""
    with contextlib.suppress(CallError):
        call = ServiceCall(1.0)
        Server(marker(), Trigger).look(call)
        end(f"bridge: {call.said.get('callerid')} joins this master and this domain already")
    # One that is starting too, or that is stopped, does not answer.
    master = uuid.uuid5(uuid.NAMESPACE_URL, rosgraph.get_master_uri().rstrip("/"))
    try:
        _held.bind(f"\0{marker()} {master}")
    except OSError:
        end("bridge: another one on this machine joins this master and this domain already")
