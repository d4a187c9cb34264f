"""Single instance: prevents a second bridge between the same master and domain."""

import contextlib
import os
import socket
import uuid

import rosgraph

from nodekit import CallError, probe_service
from nodekit.entry_point import end

#: Highest domain id; its ports are the last valid ones.
_LAST_DOMAIN = 232
#: Only one process of a machine can hold its name, until the process ends.
_held = socket.socket(socket.AF_UNIX)


def domain() -> int:
    """Return the ROS 2 domain id.

    :raises ValueError: if the environment has an invalid one
    """
    given = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not given.isdecimal() or int(given) > _LAST_DOMAIN:
        raise ValueError(
            f"ROS_DOMAIN_ID is '{given}': must be a whole number in [0, {_LAST_DOMAIN}]"
        )
    return int(given)


def marker() -> str:
    """Return the service name that marks a bridge between this master and this domain."""
    return f"/ros2_bridge_of_domain_{domain()}"


def exit_if_second() -> None:
    """Exit if such a bridge is running: two would forward messages to each other forever."""
    try:
        name = marker()
    except ValueError as error:
        end(f"bridge: {error}")
    with contextlib.suppress(CallError):
        other = probe_service(name, 1.0).get("callerid")
        end(f"bridge: {other} already connects this master and this domain")
    # A bridge that is starting or suspended does not answer.
    master = uuid.uuid5(uuid.NAMESPACE_URL, rosgraph.get_master_uri().rstrip("/"))
    try:
        _held.bind(f"\0{name} {master}")
    except OSError:
        end("bridge: another bridge on this machine already connects this master and this domain")
