"""Single instance: prevents a second bridge between the same master and domain."""

import contextlib
import os
import socket
import uuid

import rosgraph

from nodekit import CallError, probe_service
from nodekit.entry_point import end

#: The highest number of a domain: its ports are the last ones.
_LAST_DOMAIN = 232
#: Its name only one process of a machine can have at a time, until it ends, in whatever way.
_held = socket.socket(socket.AF_UNIX)


def domain() -> int:
    """Return the number of ROS 2's domain.

    :raises ValueError: if the environment does not have a legal one
    """
    given = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not given.isdecimal() or int(given) > _LAST_DOMAIN:
        raise ValueError(
            f"ROS_DOMAIN_ID is '{given}': must be a whole number in [0, {_LAST_DOMAIN}]"
        )
    return int(given)


def marker() -> str:
    """Return the service that one bridge between this master and this domain offers."""
    return f"/ros2_bridge_of_domain_{domain()}"


def exit_if_second() -> None:
    """End where there is such a bridge already: two would forward to each other for ever."""
    try:
        name = marker()
    except ValueError as error:
        end(f"bridge: {error}")
    with contextlib.suppress(CallError):
        other = probe_service(name, 1.0).get("callerid")
        end(f"bridge: {other} already connects this master and this domain")
    # One that is starting too, or that is stopped, does not answer.
    master = uuid.uuid5(uuid.NAMESPACE_URL, rosgraph.get_master_uri().rstrip("/"))
    try:
        _held.bind(f"\0{name} {master}")
    except OSError:
        end("bridge: another one on this machine already connects this master and this domain")
