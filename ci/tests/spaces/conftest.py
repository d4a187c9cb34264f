"""For the tests that build the packages outside the workspace's own spaces."""

import os
import pathlib
from typing import Dict, Set
from xml.etree import ElementTree

import pytest

SOURCES = pathlib.Path(__file__).resolve().parents[3] / "src"
PACKAGES = sorted(manifest.parent for manifest in SOURCES.glob("*/package.xml"))


@pytest.fixture(scope="session")
def underlay() -> Dict[str, str]:
    """The environment without the workspace's devel space; messages for Python only.

    What other languages but Python would generate takes longest.
    """
    environment = {**os.environ, "ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"}
    for name in ("CMAKE_PREFIX_PATH", "PYTHONPATH", "ROS_PACKAGE_PATH"):
        entries = environment.get(name, "").split(":")
        mine = str(SOURCES.parent) + "/"
        environment[name] = ":".join(entry for entry in entries if not entry.startswith(mine))
    return environment


def needed(package: str) -> Set[str]:
    """Return the packages of the workspace that one needs, and itself; not those of its tests."""
    names = {folder.name for folder in PACKAGES}
    tags = ElementTree.parse(str(SOURCES / package / "package.xml")).getroot()
    found = {package}
    for tag in tags:
        name = (tag.text or "").strip()
        if tag.tag.endswith("depend") and tag.tag != "test_depend" and name in names:
            found |= needed(name)
    return found
