"""Domains of ROS 2 that no other process on this machine has."""

import contextlib
import random
import socket
from typing import List

#: Each has a name that one process of a machine can have at a time: that of its domain.
_held: List[socket.socket] = []


def own_domain() -> int:
    """Return the number of a domain that no tests beside these have, until this process ends."""
    for number in random.sample(range(20, 97), 77):
        holding = socket.socket(socket.AF_UNIX)
        with contextlib.suppress(OSError):
            holding.bind(f"\0ros2_tests_in_domain_{number}")
            _held.append(holding)
            return number
        holding.close()
    raise AssertionError("every domain has tests")
