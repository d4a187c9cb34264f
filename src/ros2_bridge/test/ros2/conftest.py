"""A master, a bridge, and clients of both ROSes in the tests' own process.

Run by ``./ci/test ros2``, with the Python that has ROS 2 and ROS 1's packages in PYTHONPATH.
"""

import contextlib
import os
import random
import socket
from typing import Iterator

import pytest

from ros2_bridge.environment.side_by_side import join

#: Has a name that one process of a machine can have at a time: that of its domain.
_held = socket.socket(socket.AF_UNIX)


def own_domain() -> int:
    """Return the number of a domain that no tests beside these have, until this process ends."""
    for number in random.sample(range(20, 97), 77):
        with contextlib.suppress(OSError):
            _held.bind(f"\0ros2_tests_in_domain_{number}")
            return number
    raise AssertionError("every domain has tests")


# Nobody else's nodes; set before rclpy is there.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(own_domain())
join()

import both  # noqa: E402  (what it imports is ROS 2's from here on)


@pytest.fixture(scope="session")
def ros() -> Iterator["both.Both"]:
    """A master, and a node of the tests in either ROS."""
    with both.Both() as made:
        yield made


@pytest.fixture(scope="module")
def bridge(ros: "both.Both") -> Iterator["both.Bridge"]:
    """A bridge for the tests of a module."""
    with both.Bridge() as running:
        yield running
