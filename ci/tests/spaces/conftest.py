"""Fixtures for tests that build the packages outside the workspace's own spaces."""

import os
import pathlib
import subprocess
from typing import Any, Dict, List

import pytest
import rosgraph

from ci.lint.tables import needed
from nodekit.testing.waiting import wait_until

SOURCES = pathlib.Path(__file__).resolve().parents[3] / "src"
WORKSPACE = SOURCES.parent
PACKAGES = sorted(manifest.parent for manifest in SOURCES.glob("*/package.xml"))
PAGE = WORKSPACE / "docs" / "tutorials" / "other_packages.md"
READ = f"workspace='{WORKSPACE}'; source '{WORKSPACE}/ci/systems/pages.bash'; page_commands \"$@\""


def commands(section: str) -> List[str]:
    """Return the commands of a section of the page, unchanged."""
    page = str(PAGE.relative_to(WORKSPACE))
    printed = subprocess.check_output(["bash", "-c", READ, "bash", page, section], timeout=30)
    return printed.decode().splitlines()


def wait_for_master(launch: "subprocess.Popen[Any]") -> None:
    """Wait until the master of a launch answers."""
    wait_until(
        lambda: launch.poll() is not None or rosgraph.is_master_online(),
        lambda: "no master",
        60.0,
    )
    assert launch.poll() is None


@pytest.fixture(scope="session")
def underlay() -> Dict[str, str]:
    """Return the environment without the workspace's devel space; messages for Python only.

    Other languages would take most of the time.
    """
    environment = {**os.environ, "ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"}
    for name in ("CMAKE_PREFIX_PATH", "PYTHONPATH", "ROS_PACKAGE_PATH"):
        entries = environment.get(name, "").split(":")
        mine = str(WORKSPACE) + "/"
        environment[name] = ":".join(entry for entry in entries if not entry.startswith(mine))
    return environment


@pytest.fixture(scope="session")
def user(tmp_path_factory: "pytest.TempPathFactory", underlay: Dict[str, str]) -> Dict[str, str]:
    """Return the environment of a user with their own workspace ~/my_ws, built as on the page.

    ci/exec builds all packages with the same program: here it builds those of the course.
    """
    home = tmp_path_factory.mktemp("own")
    (home / "my_ws" / "src").mkdir(parents=True)
    environment = {**underlay, "HOME": str(home)}
    build, _ = commands("All of it in your own workspace")
    build += f" -DCATKIN_WHITELIST_PACKAGES='{';'.join(sorted(needed('basic_comms')))}'"
    subprocess.check_call(["bash", "-c", build.replace("URL", str(WORKSPACE))], env=environment)
    return environment
