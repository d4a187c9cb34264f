"""A small catkin workspace of its own around a copy of ci/, for the tests of ci/exec."""

import os
import pathlib
import shutil
import subprocess
from typing import Dict, Optional

import pytest

CI = pathlib.Path(__file__).resolve().parents[2]

PACKAGE_XML = """<package format="3">
  <name>%(name)s</name> <version>0.0.0</version> <description>For a test.</description>
  <maintainer email="nobody@example.invalid">nobody</maintainer> <license>BSD-3-Clause</license>
  <buildtool_depend>catkin</buildtool_depend>
  <build_depend>message_generation</build_depend> <exec_depend>message_runtime</exec_depend>
</package>
"""
CMAKE_LISTS = """cmake_minimum_required(VERSION 3.5)
project(%(name)s)
find_package(catkin REQUIRED COMPONENTS message_generation)
file(GLOB messages RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/msg msg/*.msg)
add_message_files(FILES ${messages})
generate_messages()
catkin_package()
"""


class Workspace:
    """A catkin workspace with ci/exec in it.

    Fakes are shell functions in the environment: bash imports them and prefers them to
    commands of the same name.
    """

    def __init__(self, root: pathlib.Path) -> None:
        self.root = root
        self.fakes: Dict[str, str] = {}
        shutil.copytree(CI, root / "ci", ignore=shutil.ignore_patterns("__pycache__", "tests"))
        self.add_package("tiny")

    def add_package(self, name: str) -> None:
        """Write a package with one message, Beat."""
        package = self.root / "src" / name
        (package / "msg").mkdir(parents=True)
        (package / "package.xml").write_text(PACKAGE_XML % {"name": name})
        (package / "CMakeLists.txt").write_text(CMAKE_LISTS % {"name": name})
        (package / "msg" / "Beat.msg").write_text("float64 period  # s\n")

    def environment(self, changes: Optional[Dict[str, Optional[str]]] = None) -> Dict[str, str]:
        """The caller's environment with the fakes in it; a change to None removes a variable."""
        environment = dict(os.environ)
        for name in ("ROS_HOSTNAME", "ROS_IP", "ROS_MASTER_URI", "CI_EXEC_NO_INSTALL"):
            environment.pop(name, None)
        for name, body in self.fakes.items():
            environment["BASH_FUNC_%s%%%%" % name] = "() { %s\n}" % body
        for key, value in (changes or {}).items():
            environment.pop(key, None)
            if value is not None:
                environment[key] = value
        return environment

    def start(self, *command: str, **changes: Optional[str]) -> "subprocess.Popen[str]":
        """Start ci/exec in a process group of its own."""
        return subprocess.Popen(
            [str(self.root / "ci" / "exec")] + list(command),
            env=self.environment(changes),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            start_new_session=True,
        )

    def run(
        self, *command: str, stdin: str = "", **changes: Optional[str]
    ) -> "subprocess.CompletedProcess[str]":
        """Run ci/exec to its end."""
        process = self.start(*command, **changes)
        out, err = process.communicate(stdin, timeout=120)
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def shows(self, message: str) -> bool:
        """Whether Python code in the workspace finds a message, given as package.Name."""
        package, name = message.split(".")
        code = "from %s.msg import %s" % (package, name)
        return self.run("python3", "-c", code).returncode == 0

    def pretend_packages(self, listed: str, installed: str = "", known: str = "") -> pathlib.Path:
        """Replace the list of packages and the package system; return the log of root's commands.

        Nothing is built then: these tests are about what comes before.
        ``apt-get update`` makes every listed package known, ``apt-get install`` installs it, by
        name or from a file. ``apt-helper`` makes an empty file.
        """
        (self.root / "ci" / "apt-packages.txt").write_text(listed)
        system = self.root / "system"
        system.mkdir()
        log = system / "log"
        log.write_text("")
        (system / "installed").write_text(installed)
        (system / "known").write_text(known)
        self.fakes.update(
            {
                "dpkg-query": "sed 's/^/installed /' '%s/installed'" % system,
                "apt-cache": r"sed 's/\(.*\)/\1:\n  Candidate: 1.0/' '%s/known'" % system,
                "apt-get": "echo 'Debian http://mirror/debian/'",  # to indextargets
                "apt-helper": """echo "$*" >> '%s/log'; touch "$3" """ % system,
                "sudo": '"$@"',
                "catkin_make": "mkdir -p devel; : > devel/setup.bash",
                "env": """
                    while [[ $1 == *=* ]]; do shift; done
                    echo "$*" >> '{0}/log'
                    case $2 in
                        update) cat '{0}/mirror' > '{0}/known' ;;
                        install)
                            for word; do basename "$word" .deb; done >> '{0}/installed' ;;
                    esac""".format(
                    system
                ),
            }
        )
        (system / "mirror").write_text(known)
        return log


@pytest.fixture
def workspace(tmp_path: pathlib.Path) -> Workspace:
    """A workspace that nothing has been built in."""
    return Workspace(tmp_path / "a workspace")


@pytest.fixture(scope="session")
def built(tmp_path_factory: "pytest.TempPathFactory") -> Workspace:
    """A built workspace, for tests that change nothing in it."""
    workspace = Workspace(tmp_path_factory.mktemp("built"))
    assert workspace.run("true").returncode == 0
    return workspace
