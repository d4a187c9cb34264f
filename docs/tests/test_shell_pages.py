"""Commands that pages show without their output, in blocks of the language sh, can be typed."""

from concurrent.futures import Future
from typing import Dict, List

import pytest
from pages import texts_of_pages
from reader import PageError
from typist import Line, Typist, lines_of
from warm_python import WarmPython

PAGES = texts_of_pages()

#: What a reader of the page has at that point, as lines to be typed.
BEFORE: Dict[str, List[str]] = {
    "docs/nodes/mask.md": ["roslaunch basic_comms cw1.launch signal_rate:=100"],
    "docs/nodes/plot_bag.md": [
        "roslaunch basic_comms cw1.launch signal_rate:=100",
        "rosbag record -O FILE.bag --limit=400 /signal /proc_signal",
    ],
    "docs/nodes/signal_generator.md": ["echo 'amplitude: 2.5' > my_settings.yaml"],
    "docs/parameters.md": [
        "roslaunch $(rospack find basic_comms)/launch/{cw1,groups}.launch count:=1"
    ],
}

_TWO_HOSTS = "needs a second host: ci/two-hosts does it"
_NETWORK = "needs a network of its own, thus root: ci/two-hosts does it"
_TIER = "is a step of ci/test itself"
_README = "is typed for README.md"

#: Beginnings of lines that are not typed here, and why.
NOT_TYPED = {
    "README.md": {"./ci/test": _TIER},
    "docs/benchmark.md": {"./ci/bench": "takes five minutes of a quiet machine"},
    "docs/container.md": {
        line: "takes minutes of building, and podman: ci/container types it"
        for line in ("podman", "git log", "./ci/container")
    },
    "docs/development.md": {
        line: _TIER for line in ("./ci/test", "./ci/exec python3 -m", "./ci/exec rostest")
    },
    "docs/index.md": {line: _README for line in ("./ci/exec roslaunch", "rostopic echo /signal")},
    "docs/launch_files.md": {"roslaunch --ros-args": _README},
    "docs/nodes/my_robot_package.md": {
        line: "logs errors on purpose: my_robot_package's nodes.test does it"
        for line in (
            "roslaunch my_robot_package logging_node",
            "rosservice call /logging_node",
            "roslaunch my_robot_package robust_node",
        )
    },
    "docs/nodes/serial_link.md": {
        "rosservice call /zero_encoder": "is the board's own, and comes when the board has told of "
        "it: the tutorial of the microcontroller types it"
    },
    "docs/lab.md": {"echo": "writes a setting for all users, as root"},
    "docs/packaging.md": {
        "./ci/deb": "takes root, and minutes of building",
        "sudo apt": "takes the packages: ci/deb types it",
        **{
            line: "is for who has installed the packages: ci/deb types it"
            for line in ("roslaunch", "rosrun")
        },
    },
    "docs/ros2_bridge.md": {
        **{
            line: "takes an environment with ROS 2: ci/test ros2 does it"
            for line in (
                "./ci/ros2",
                "./ci/exec roslaunch ros2_bridge",
                "./ci/exec rosrun ros2_bridge",
            )
        },
        "ROS_MASTER_URI": "takes two machines, and an environment with ROS 2",
    },
    "docs/security.md": {
        "sudo iptables": _NETWORK,
        "unshare": _NETWORK,
        "nsenter": _NETWORK,
        "ssh": _TWO_HOSTS,
    },
    "docs/tutorials/other_packages.md": {
        **{
            line: "builds for a while: test_own_workspace.py of ci/test does it"
            for line in ("git clone", "source ~/my_ws")
        },
        **{
            line: "is the same for some packages: test_own_workspace.py looks at what these need"
            for line in ("cp -r", "cd ~/my_ws", "source devel", "roslaunch")
        },
    },
    "docs/tutorials/package_in_python.md": {
        line: _TIER for line in ("catkin_make run_tests", "rostest", "python3 -m pytest")
    },
    "docs/tutorials/test_your_node.md": {
        "catkin_make run_tests_PACKAGE": "is for a package of the reader's own",
        "catkin_test_results": "is for a package of the reader's own",
    },
    "docs/two_hosts.md": {
        line: _TWO_HOSTS for line in ("export", "./ci/exec roslaunch", "ssh-", "ssh ")
    },
}


def typed_lines(page: str) -> List[Line]:
    """List the lines of a page that are typed."""
    not_typed = tuple(NOT_TYPED.get(page, {}))
    lines = lines_of(PAGES[page])
    return [line for line in lines if not line.command.startswith(not_typed)]


def effort(page: str) -> int:
    """Estimate how long a page takes."""
    return sum(10 if "launch" in line.command else 1 for line in typed_lines(page))


def type_page(page: str, python: WarmPython) -> None:
    """Do all that a page says."""
    with Typist(python) as typist:
        for command in BEFORE.get(page, []):
            typist.type(command)
        for line in typed_lines(page):
            try:
                typist.type(line.command)
            except Exception as error:
                raise PageError(f"{page}:{line.number}: {line.command}\n{error}") from None


@pytest.mark.parametrize("page", [page for page in PAGES if typed_lines(page)])
def test_page_commands_succeed(page: str, typed: "Future[None]") -> None:
    typed.result()


def test_line_that_is_not_typed_is_still_there() -> None:
    of_readme = {line.command.partition("#")[0].rstrip() for line in typed_lines("README.md")}
    assert NOT_TYPED
    for page, starts in NOT_TYPED.items():
        lines = [line.command for line in lines_of(PAGES[page])]
        assert starts, page
        for start in starts:
            found = {line for line in lines if line.startswith(start)}
            assert found, f"{page}: {start}"
            if starts[start] == _README:
                assert found <= of_readme


@pytest.mark.parametrize("language", ["bash", "shell", "zsh", "shell-session"])
def test_no_page_has_a_block_of_another_shell_language(language: str) -> None:
    assert [page for page, text in PAGES.items() if lines_of(text, language)] == []
