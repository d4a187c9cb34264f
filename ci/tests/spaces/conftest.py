"""For the tests that build the packages outside the workspace's own spaces."""

import os
import pathlib
from typing import Dict

import pytest

SOURCES = pathlib.Path(__file__).resolve().parents[3] / "src"
PACKAGES = sorted(manifest.parent for manifest in SOURCES.glob("*/package.xml"))


@pytest.fixture(scope="session")
def underlay() -> Dict[str, str]:
    """The environment without what the workspace's devel space has put into it."""
    environment = dict(os.environ)
    for name in ("CMAKE_PREFIX_PATH", "PYTHONPATH", "ROS_PACKAGE_PATH"):
        entries = environment.get(name, "").split(":")
        mine = str(SOURCES.parent) + "/"
        environment[name] = ":".join(entry for entry in entries if not entry.startswith(mine))
    return environment
