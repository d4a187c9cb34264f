"""A master, a bridge, and clients of both ROSes in the tests' own process.

Run by ``./ci/test ros2``, with the Python that has ROS 2 and ROS 1's packages in PYTHONPATH.
"""

import os
from typing import Iterator, List

import pytest
from domains import own_domain

from ros2_bridge.environment.module_isolation import join

# Excludes other users' nodes; set before rclpy is imported.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(own_domain())
join()

import both  # noqa: E402  (what it imports is ROS 2's from here on)


#: Compares all that a bridge shows, of which other modules would leave traces for a while.
_FIRST = "test_answers"
#: Kills the master, which forgets all that this process has registered.
_LAST = "test_life"


def pytest_configure(config: "pytest.Config") -> None:
    """Register the mark by which the modules can be run in two parallel sessions."""
    config.addinivalue_line("markers", "shared_bridge: of a module that uses the shared bridge")


@pytest.hookimpl(tryfirst=True)  # before -m is looked at
def pytest_collection_modifyitems(items: "List[pytest.Item]") -> None:
    """Run modules that share a bridge one after the other, so that it starts only once."""
    sharing = {item.path.stem for item in items if "bridge" in getattr(item, "fixturenames", ())}
    for item in items:
        if item.path.stem in sharing:
            item.add_marker("shared_bridge")

    def rank(item: "pytest.Item") -> int:
        name = item.path.stem
        return 0 if name == _FIRST else 3 if name == _LAST else 1 if name in sharing else 2

    items.sort(key=rank)


@pytest.fixture(scope="session")
def ros() -> Iterator["both.Both"]:
    """Return a master, and a node of the tests in either ROS; all modules share them."""
    with both.Both() as made:
        yield made


@pytest.fixture(scope="module")
def bridge(ros: "both.Both") -> Iterator["both.Bridge"]:
    """Return the bridge that modules share, with an empty log and the initial settings.

    Modules that test the start, the end, the settings or the faults of a bridge create their own
    bridges, ``both.Bridge``, which stop this one.
    """
    running = both.shared_bridge()
    with both.settings_restored(ros, running):
        yield running
    running.print_log()
