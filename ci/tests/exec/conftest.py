"""Fixture of a small catkin workspace with a copy of ci/, for the tests of ci/exec."""

import os
import pathlib
import shutil
import subprocess
from typing import Dict, List, Optional

import pytest

CI = pathlib.Path(__file__).resolve().parents[2]

PACKAGE_XML = """<package format="3">
  <name>%(name)s</name> <version>0.0.0</version> <description>For a test.</description>
  <maintainer email="author@example.invalid">author</maintainer> <license>BSD-3-Clause</license>
  <buildtool_depend>catkin</buildtool_depend>
  <build_depend>message_generation</build_depend> <exec_depend>message_runtime</exec_depend>
  %(more)s
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
APT_GET = """
    case "$*" in
        update*--print-uris*)
            echo "'http://mirror/debian/dists/a/InRelease' mirror_InRelease 0 "
            echo "'http://mirror/debian/dists/a-updates/InRelease' mirror_InRelease 0 "
            return ;;
        *--print-uris*) echo "'http://mirror/debian/pool/one.deb' one.deb 1 "; return ;;
    esac
    echo "apt-get $*" >> 'SYSTEM/log'
    case $1 in
        update) cat 'SYSTEM/mirror' > 'SYSTEM/known' ;;
        install)
            for word in $(printf '%s\\n' "$@" | grep -vE '^(install|-.*|.*=.*)$'); do
                grep -qx "$word" 'SYSTEM/known' ||
                    { echo "E: Unable to locate package $word"; return 100; }
                echo "$word" >> 'SYSTEM/installed'
            done ;;
    esac"""


class Workspace:
    """A catkin workspace with ci/exec in it.

    Fakes are shell functions in the environment: bash imports them and prefers them to
    commands of the same name.
    """

    def __init__(self, root: pathlib.Path) -> None:
        self.root = root
        self.fakes: Dict[str, str] = {}
        #: In ci/.
        self.program = "exec"
        #: Command that runs it.
        self.prefix: List[str] = []
        #: Result of the run that built it.
        self.first: "subprocess.CompletedProcess[str]"
        shutil.copytree(CI, root / "ci", ignore=shutil.ignore_patterns("__pycache__", "tests"))
        (root / "packaging").mkdir()
        shutil.copy(str(CI.parent / "packaging" / "dependencies.txt"), str(root / "packaging"))
        self.add_package("tiny")

    def add_package(self, name: str, more: str = "") -> None:
        """Write a package with one message, Beat, and more in its package.xml."""
        package = self.root / "src" / name
        (package / "msg").mkdir(parents=True)
        (package / "package.xml").write_text(PACKAGE_XML % {"name": name, "more": more})
        (package / "CMakeLists.txt").write_text(CMAKE_LISTS % {"name": name})
        (package / "msg" / "Beat.msg").write_text("float64 period  # s\n")

    def environment(self, changes: Optional[Dict[str, Optional[str]]] = None) -> Dict[str, str]:
        """Return the caller's environment with the fakes; a change to None removes a variable."""
        environment = dict(os.environ)
        for name in (
            "ROS_HOSTNAME",
            "ROS_IP",
            "ROS_MASTER_URI",
            "CI_EXEC_NO_INSTALL",
            "ROS_LANG_DISABLE",
        ):
            environment.pop(name, None)
        for name, body in self.fakes.items():
            environment[f"BASH_FUNC_{name}%%"] = "() { %s\n}" % body
        for key, value in (changes or {}).items():
            environment.pop(key, None)
            if value is not None:
                environment[key] = value
        return environment

    def start(self, *command: str, **changes: Optional[str]) -> "subprocess.Popen[str]":
        """Start the program in its own process group."""
        return subprocess.Popen(
            self.prefix + [str(self.root / "ci" / self.program)] + list(command),
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
        """Run the program to its end."""
        process = self.start(*command, **changes)
        out, err = process.communicate(stdin, timeout=120)
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def pretend_build(self, first: str = "") -> None:
        """Replace catkin_make, for tests of when it is run.

        :param first: bash code that it runs at first
        """
        self.fakes["catkin_make"] = f"""{first or ":"}
            mkdir -p devel; : > devel/product; [ -e devel/setup.bash ] || : > devel/setup.bash
            echo CMAKE_HOME_DIRECTORY:INTERNAL=$PWD/src > build/CMakeCache.txt"""

    def pretend_packages(self, listed: str, installed: str = "", known: str = "") -> pathlib.Path:
        """Replace the list of packages and the package system; return the log of root's commands.

        Nothing is built then: these tests are about the steps before. ``apt-get update`` makes
        every package of the mirror known, ``apt-get install`` installs known packages.
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
                "dpkg-query": f"sed 's/^/installed /' '{system}/installed'",
                "apt-cache": rf"sed 's/\(.*\)/\1:\n  Candidate: 1.0/' '{system}/known'",
                "apt-get": APT_GET.replace("SYSTEM", str(system)),
                "apt-helper": "true",  # the archive answers
                "timeout": 'shift; "$@"',
                "sudo": '"$@"',
                "env": 'while [[ $1 == *=* ]]; do shift; done; "$@"',
                "catkin_make": "mkdir -p devel; : > devel/setup.bash",
            }
        )
        (system / "mirror").write_text(known)
        self.pretend_release("bookworm")
        return log

    def pretend_release(self, codename: str) -> None:
        """Replace the file that names the release of Debian."""
        release = self.root / "system" / "os-release"
        release.write_text(f"PRETTY_NAME='a Debian'\nVERSION_CODENAME={codename}\n")
        self.patch("setup.bash", "=/etc/os-release\n", f"='{release}'\n")

    def patch(self, name: str, old: str, new: str) -> None:
        """Replace text in a file of ci/setup."""
        path = self.root / "ci" / "setup" / name
        path.write_text(path.read_text().replace(old, new))

    def give_away(self, place: str) -> None:
        """Remove the right to write to a file or folder, even for root."""
        os.chmod(str(self.root / place), 0o555)
        if os.geteuid() == 0:
            self.prefix = ["setpriv", "--bounding-set=-dac_override", "--"]

    def be_somebody(self, name: str = "daemon") -> None:
        """Make ci/exec see a user without rights."""
        names = f"case $1 in -u) echo 12345 ;; -nu) [ $# = 1 ] && echo {name} ||"
        self.fakes["id"] = names + ' command id "$@" ;; esac'


@pytest.fixture
def workspace(tmp_path: pathlib.Path) -> Workspace:
    """Return a workspace that has not been built."""
    return Workspace(tmp_path / "workspace")


@pytest.fixture(scope="session")
def built(tmp_path_factory: "pytest.TempPathFactory") -> Workspace:
    """Return a built workspace, for tests that change nothing in it."""
    # Rare but allowed characters of a path.
    workspace = Workspace(tmp_path_factory.mktemp("built") / "é+@=%,~-1")
    script = "cat; python3 -c 'import tiny.msg'; ls -l /proc/self/fd | grep -c lock; exit 7"
    workspace.first = workspace.run("sh", "-c", script, stdin="in\n")
    assert workspace.first.returncode == 7, workspace.first.stderr
    return workspace
