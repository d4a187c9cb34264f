"""Environment variables of the ROS 2 middleware."""

import pathlib
from typing import Dict, Mapping

#: The only machine whose nodes are seen.
LOCALHOST = "LOCALHOST"


def middleware(environ: Mapping[str, str], loopback: pathlib.Path) -> Dict[str, str]:
    """Return the variables that ROS 2's middleware is to read.

    It sends by UDP, not through shared memory. There, who takes the port of a process that was
    killed removes what that has left, while others may go on writing into it: a bridge that was
    killed and started again could receive nothing (eProsima/Fast-DDS#5053).

    :param environ: variables of now; what is chosen in them stays
    :param loopback: file with the profile for nodes of this machine. rmw_fastrtps has its own for
        them otherwise, with shared memory, whatever other variables say
    """
    given = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", **environ}
    # The only one there; another one, chosen for a ROS 2 elsewhere, would end the process.
    given["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
    # As our ROS 1 side: nodes of other machines are not seen unless that is asked for.
    reach = given.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", LOCALHOST)
    chosen = {"ROS_STATIC_PEERS", "FASTRTPS_DEFAULT_PROFILES_FILE"}.intersection(environ)
    if reach == LOCALHOST and not chosen:
        given["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
        given["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(loopback)
    return given
