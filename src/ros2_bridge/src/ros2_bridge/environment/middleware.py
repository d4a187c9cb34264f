"""Environment variables for the ROS 2 middleware (Fast DDS): UDP, this machine only by default."""

import pathlib
from typing import Dict, Mapping

#: Restricts discovery to this machine.
LOCALHOST = "LOCALHOST"
#: UDP with socket buffers for more than two images of 6 MB, which arrive in bursts: Linux's 208 KB
#: overflow at the first, and resending delays and loses images. Linux limits the size to
#: net.core.rmem_max. ``loopback.xml`` sets the same.
UDP = "UDPv4?sockets_size=16MB"


def middleware(environ: Mapping[str, str], loopback: pathlib.Path) -> Dict[str, str]:
    """Return the environment variables for the ROS 2 middleware.

    UDP replaces shared memory: a process that reuses the port of a killed process removes its
    shared-memory segment while others may still write into it, so a bridge that was killed and
    restarted could receive nothing (eProsima/Fast-DDS#5053).

    :param environ: current variables; explicit settings are kept
    :param loopback: file with the profile for localhost. Without it, rmw_fastrtps uses its own
        profile there, with shared memory, regardless of other variables
    """
    given = {"FASTDDS_BUILTIN_TRANSPORTS": UDP, **environ}
    # The only middleware installed; another one, set for a ROS 2 elsewhere, would end the process.
    given["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
    if environ.get("ROS_DISCOVERY_SERVER"):
        given.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
        # Otherwise the server announces only topics for which this process has an endpoint.
        given.setdefault("ROS_SUPER_CLIENT", "TRUE")
    # As on the ROS 1 side, nodes of other machines are invisible by default.
    reach = given.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", LOCALHOST)
    chosen = {"ROS_STATIC_PEERS", "FASTRTPS_DEFAULT_PROFILES_FILE"}.intersection(environ)
    if reach == LOCALHOST and not chosen:
        given["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
        given["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(loopback)
    return given
