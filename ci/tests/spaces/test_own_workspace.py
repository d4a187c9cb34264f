"""In a workspace of one's own: a clone of all of it builds, and of the packages few are enough."""

import os
import pathlib
import re
import signal
import subprocess
from typing import Dict, Iterator, List

import pytest

from .conftest import SOURCES, needed

WORKSPACE = SOURCES.parent
PAGE = WORKSPACE / "docs" / "tutorials" / "other_packages.md"
READ = f"workspace='{WORKSPACE}'; source '{WORKSPACE}/ci/systems/pages.bash'; page_commands \"$@\""


def commands(section: str) -> List[str]:
    """The commands of a section of the page, as they stand there."""
    page = str(PAGE.relative_to(WORKSPACE))
    printed = subprocess.check_output(["bash", "-c", READ, "bash", page, section], timeout=30)
    return printed.decode().splitlines()


@pytest.fixture(scope="module")
def environment(
    tmp_path_factory: "pytest.TempPathFactory", underlay: Dict[str, str]
) -> Dict[str, str]:
    """That of a user with a workspace."""
    return {**underlay, "HOME": str(tmp_path_factory.mktemp("own"))}


@pytest.fixture(scope="module")
def launched(environment: Dict[str, str]) -> Iterator["subprocess.Popen[bytes]"]:
    """What the page says: one command that builds, one that runs."""
    build, run = commands("All of it in your own workspace")
    pathlib.Path(environment["HOME"], "my_ws", "src").mkdir(parents=True)
    subprocess.check_call(["bash", "-c", build.replace("URL", str(WORKSPACE))], env=environment)
    # roslaunch and its shell get the Ctrl-C.
    launch = subprocess.Popen(["bash", "-c", run], env=environment, start_new_session=True)
    yield launch
    os.killpg(launch.pid, signal.SIGINT)
    launch.wait(timeout=60)


def test_the_course_runs(launched: "subprocess.Popen[bytes]", environment: Dict[str, str]) -> None:
    def within(*command: str) -> List[str]:
        setup = 'source "$HOME/my_ws/devel/setup.bash" && exec "$@"'
        return ["bash", "-c", setup, "bash", *command]

    while subprocess.call(within("rosnode", "list"), env=environment, timeout=60) != 0:
        assert launched.poll() is None
    heard = subprocess.check_output(
        within("rostopic", "echo", "-n", "1", "/proc_signal"), env=environment, timeout=60
    )
    assert heard.startswith(b"data: ")
    described = subprocess.check_output(
        within("rosrun", "nodekit", "describe", "/process"), env=environment, timeout=60
    )
    assert b"amplitude_scale" in described


def test_what_the_page_says_to_copy_is_all_that_is_needed() -> None:
    section = PAGE.read_text("utf-8").partition("\n## Take nodekit")[2].partition("\n## ")[0]
    rows = re.findall(r"^\|.*\| (nodekit, .*) \|$", section, re.MULTILINE)
    copied = [row.split(", ") for row in rows]
    copied += [
        re.findall(r"src/(\w+)", line)
        for line in commands("Take nodekit into your own workspace")[:1]
    ]
    assert len(copied) == 4
    for names in copied:
        assert set().union(*map(needed, names)) == set(names)


def test_what_the_page_says_of_a_new_package_stands_in_it() -> None:
    section = PAGE.read_text("utf-8").partition("\nA package made by [rosrun nodekit new]")[2]
    told = re.findall(r"^<exec_depend>.*$", section, re.MULTILINE)
    template = SOURCES / "nodekit" / "template" / "package_name" / "package.xml"
    lines = [line.strip() for line in template.read_text("utf-8").splitlines()]
    assert "<exec_depend>rospy</exec_depend>" in told
    assert all(lines.count(line) == 1 for line in told)
