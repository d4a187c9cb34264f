"""A master, a bridge, and clients of both ROSes in the tests' own process.

Run by ``./ci/test ros2``, with the Python that has ROS 2 and ROS 1's packages in PYTHONPATH.
"""

import os
from typing import Iterator

import pytest
from domains import own_domain

from ros2_bridge.environment.side_by_side import join

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
