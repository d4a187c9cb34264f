"""Address that this process announces (ROS_IP, ROS_HOSTNAME): its default, and a check of it."""

import os
import socket
import sys
from typing import Mapping, MutableMapping, Sequence
from urllib.parse import urlsplit

import rosgraph.network

_ARGUMENTS = ("__hostname:=", "__ip:=")
_VARIABLES = ("ROS_HOSTNAME", "ROS_IP")
#: Longest wait for the process's own connection [s].
_TIMEOUT_S = 3.0


class AddressError(ValueError):
    """Error of an address under which this machine does not reach itself."""


def default_to_loopback(environ: MutableMapping[str, str], argv: Sequence[str]) -> None:
    """Make rospy listen on the loopback device only, unless the user has set an address.

    A master on another machine counts as an address: nodes there must reach this process.

    :param environ: variables of the environment, which are changed
    :param argv: arguments of the command line
    """
    if source(environ, argv) or not _is_loopback(environ.get("ROS_MASTER_URI", ""), argv):
        return
    if rosgraph.network.use_ipv6() and not _has_ipv6_loopback():
        return
    environ.pop("ROS_IP", None)  # empty, which rospy takes for a name
    environ["ROS_HOSTNAME"] = "localhost"


def _has_ipv6_loopback() -> bool:
    """Return whether ``localhost`` has an IPv6 address, which depends on the machine."""
    try:
        return bool(socket.getaddrinfo("localhost", None, socket.AF_INET6))
    except OSError:
        return False


def source(environ: Mapping[str, str], argv: Sequence[str]) -> str:
    """Return the setting of the address, such as ``ROS_IP '192.0.2.1'``; empty if unset.

    In rospy's order of precedence.

    :param environ: variables of the environment
    :param argv: arguments of the command line
    """
    for argument in argv:
        if argument.startswith(_ARGUMENTS):
            return "argument '{}'".format(argument)
    return next((f"{name} '{environ[name]}'" for name in _VARIABLES if environ.get(name)), "")


def check() -> None:
    """Check that this machine reaches itself under the address that rospy announces.

    :raises AddressError: if not
    """
    host = rosgraph.network.get_host_name()
    family = socket.AF_INET6 if rosgraph.network.use_ipv6() else socket.AF_INET
    with socket.socket(family) as listener:
        listener.settimeout(_TIMEOUT_S)
        try:
            listener.bind((rosgraph.network.get_bind_address(), 0))
            listener.listen(1)
            with socket.create_connection((host, listener.getsockname()[1]), _TIMEOUT_S):
                listener.accept()[0].close()
        except OSError as error:
            given = source(os.environ, sys.argv) or f"host name '{host}'"
            allowed = ", ".join(rosgraph.network.get_local_addresses())
            raise AddressError(
                f"{given}: other nodes cannot reach this one there, nor can this machine itself "
                f"({error}); set ROS_IP to an address of this machine ({allowed}), or ROS_HOSTNAME "
                "to its name as other machines resolve it"
            ) from None


def _is_loopback(master_uri: str, argv: Sequence[str]) -> bool:
    """Return whether a master is reached over the loopback device; the default one is."""
    for argument in argv:
        if argument.startswith("__master:="):
            master_uri = argument.partition(":=")[2]
    try:
        host = urlsplit(master_uri).hostname or "localhost"
    except ValueError:  # a malformed address, which the check of the master's names
        return True
    return host in ("localhost", "::1") or host.startswith("127.")
