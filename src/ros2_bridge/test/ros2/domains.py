"""Domains of ROS 2 that no other process on this machine has."""

import contextlib
import random
import socket
from typing import List

#: Names that only one process of a machine can hold: one for each domain.
_held: List[socket.socket] = []


def own_domain() -> int:
    """Return a domain id that no parallel tests use, until this process ends."""
    for number in random.sample(range(20, 97), 77):
        holding = socket.socket(socket.AF_UNIX)
        with contextlib.suppress(OSError):
            holding.bind(f"\0ros2_tests_in_domain_{number}")
            _held.append(holding)
            return number
        holding.close()
    raise AssertionError("every domain has tests")
