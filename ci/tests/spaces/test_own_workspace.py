"""Tests of a user's own workspace: a build of all packages, and of a few copied ones."""

import os
import re
import signal
import subprocess
from typing import Dict, Iterator, List

import pytest

from ci.lint.tables import needed

from .conftest import PAGE, SOURCES, commands, wait_for_master


@pytest.fixture(scope="module")
def launched(user: Dict[str, str]) -> Iterator["subprocess.Popen[bytes]"]:
    """Return the launch that the page's second command starts."""
    _, run = commands("All of it in your own workspace")
    # roslaunch and its shell get the Ctrl-C.
    launch = subprocess.Popen(["bash", "-c", run], env=user, start_new_session=True)
    yield launch
    os.killpg(launch.pid, signal.SIGINT)
    launch.wait(timeout=300)


def test_the_course_runs(launched: "subprocess.Popen[bytes]", user: Dict[str, str]) -> None:
    def within(*command: str) -> List[str]:
        setup = 'source "$HOME/my_ws/devel/setup.bash" && exec "$@"'
        return ["bash", "-c", setup, "bash", *command]

    wait_for_master(launched)
    heard = subprocess.check_output(
        within("rostopic", "echo", "-n", "1", "/proc_signal"), env=user, timeout=300
    )
    assert heard.startswith(b"data: ")
    described = subprocess.check_output(
        within("rosrun", "nodekit", "describe", "/process"), env=user, timeout=300
    )
    assert b"amplitude_scale" in described


def test_packages_to_copy_by_the_page_are_sufficient() -> None:
    copy, *_ = commands("Take nodekit into your own workspace")
    assert set(re.findall(r"src/(\w+)", copy)) == needed("basic_comms")


def test_dependencies_on_the_page_are_in_a_new_package() -> None:
    section = PAGE.read_text("utf-8").partition("\nA package made by [rosrun nodekit new]")[2]
    told = [line for line in section.splitlines() if line.startswith("<exec_depend>")]
    template = SOURCES / "nodekit" / "template" / "package_name" / "package.xml"
    lines = [line.strip() for line in template.read_text("utf-8").splitlines()]
    assert "<exec_depend>rospy</exec_depend>" in told
    assert all(lines.count(line) == 1 for line in told)
