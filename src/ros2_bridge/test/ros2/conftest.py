"""A master, a bridge, and clients of both ROSes in the tests' own process.

Run by ``./ci/test ros2``, with the Python that has ROS 2 and ROS 1's packages in PYTHONPATH.
"""

import collections
import json
import os
import pathlib
from typing import Dict, Iterator, List, Set

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
#: Modules that use the shared bridge.
_sharing: Set[str] = set()
#: Duration of each module [s], for the next division of the modules among parallel sessions.
_durations: Dict[str, float] = collections.defaultdict(float)


def pytest_runtest_logreport(report: "pytest.TestReport") -> None:
    """Add the duration of a test, of its fixtures' setup or of their teardown."""
    _durations[report.nodeid.partition("::")[0]] += report.duration


def pytest_sessionfinish(session: "pytest.Session") -> None:
    """Write the durations beside the results, as ``./ci/test`` reads them."""
    results = session.config.getoption("xmlpath")
    if results:
        pathlib.Path(results).with_name("places.json").write_text(json.dumps(_durations), "utf-8")


def pytest_collection_modifyitems(items: "List[pytest.Item]") -> None:
    """Run modules that share a bridge one after the other, so that it starts only once."""
    _sharing.update(
        item.path.stem for item in items if "bridge" in getattr(item, "fixturenames", ())
    )

    def rank(item: "pytest.Item") -> int:
        name = item.path.stem
        return 0 if name == _FIRST else 3 if name == _LAST else 1 if name in _sharing else 2

    items.sort(key=rank)


@pytest.fixture(scope="session")
def ros() -> Iterator["both.Both"]:
    """Return a master, and a node of the tests in either ROS; all modules share them."""
    with both.Both() as made:
        yield made


@pytest.fixture(scope="module", autouse=True)
def shared_only_if_used(request: "pytest.FixtureRequest") -> None:
    """End the bridge that modules share before a module without it."""
    if request.path.stem not in _sharing:
        both.end_shared_bridge()


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
