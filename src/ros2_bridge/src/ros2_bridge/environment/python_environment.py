"""Creation of the Python environment with ROS 2, or of its missing parts.

``rosrun ros2_bridge make_environment`` does so where the bridge is installed, ``ci/ros2`` in the
workspace. Where that is not possible, it ends with status 125 and one sentence.
"""

import argparse
import hashlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
from typing import Dict, List, Mapping, Sequence
from xml.etree import ElementTree

import rospkg
import yaml

from nodekit.message_definitions import DefinitionError
from ros2_bridge.environment.start import home
from ros2_bridge.types.ros2_interfaces import RENAMED, TwinPackage, generate_interfaces

#: Versions of Python that the wheels are for.
PYTHONS = ((3, 11), (3, 12), (3, 13), (3, 14))
#: ROS 1's own packages that ROS 2 has and PyPI has not: what is bridged of them.
WITHOUT_WHEEL = {
    "tf2_msgs": {"msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n"},
}
#: Longest time for the empty environment, for what is fetched from PyPI, and for building all
#: packages [s]: on a busy machine each takes ten times as long.
VENV_LIMIT_S, FETCH_LIMIT_S, BUILD_LIMIT_S = 300.0, 900.0, 900.0
BUILDER = pathlib.Path(__file__).with_name("twin_builder.py")


class Unavailable(Exception):
    """The environment cannot be made; the text says why."""


def say(text: str) -> None:
    print(f"make_environment: {text}", file=sys.stderr, flush=True)


class PythonEnvironment:
    """A Python environment with ROS 2.

    :param folder: where it is; the sources of the twins go beside it
    """

    def __init__(self, folder: pathlib.Path) -> None:
        self._folder = folder
        self._python = folder / "bin" / "python"
        self._twins = folder.with_name(f"{folder.name}_twins")
        #: Written last: without it, the environment is incomplete.
        self._names = folder / "share" / "ros2_bridge" / "names.yaml"

    def run(self, command: Sequence[str], limit: float, what: str) -> None:
        """Run a command of the environment, without ROS 1, and with its output in a log.

        :param limit: longest time [s]
        :param what: what it does, for the sentence if it fails
        :raises Unavailable: if it fails
        """
        log = self._folder.with_name(f"{self._folder.name}.log")
        variables = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
        }
        variables["PATH"] = f"{self._folder / 'bin'}:{variables['PATH']}"
        variables["AMENT_PREFIX_PATH"] = variables["CMAKE_PREFIX_PATH"] = str(self._folder)
        try:
            with log.open("wb") as output:
                subprocess.run(
                    command,
                    check=True,
                    env=variables,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    timeout=limit,
                )
        except subprocess.TimeoutExpired:
            raise Unavailable(f"{what}: not finished within {limit:g} s") from None
        except (OSError, subprocess.CalledProcessError):
            why = first_error(log.read_text("utf-8", "replace"))
            raise Unavailable(f"{what}: {why} (see {log})") from None

    def fetch(self, wheels: pathlib.Path) -> None:
        """Install the wheels, unless just these are installed.

        :param wheels: the list of them
        :raises Unavailable: if they cannot be had
        """
        stamp = self._folder / "wheels"
        wanted = f"{self._folder}\n{sys.version}\n{wheels.read_text('utf-8')}"
        if stamp.exists() and stamp.read_text("utf-8") == wanted:
            return
        check_python()
        say(f"fetching ROS 2 from PyPI, once, into {self._folder}")
        self._remove()
        self._folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._install(wheels)
        except BaseException:
            self._remove()
            raise
        stamp.write_text(wanted, "utf-8")

    def _remove(self) -> None:
        for place in (self._folder, self._twins):
            shutil.rmtree(str(place), ignore_errors=True)

    def _install(self, wheels: pathlib.Path) -> None:
        venv = ["/usr/bin/python3", "-m", "venv", str(self._folder)]
        self.run(venv, VENV_LIMIT_S, "cannot make a virtual environment")
        # Their own lists are incomplete, so ours is complete, and pip need not ask for theirs.
        # Python compiles what is imported, which is a tenth of all, when it is.
        pip = [str(self._python), "-m", "pip", "install", "--no-deps", "--no-compile", "--quiet"]
        options = ["--retries", "1", "--disable-pip-version-check", "--requirement", str(wheels)]
        self.run([*pip, *options], FETCH_LIMIT_S, "ROS 2 cannot be installed from PyPI")

    def has_wheel(self, package: str) -> bool:
        """Tell whether a wheel brings the ROS 2 package of this name."""
        index = self._folder / "share" / "ament_index" / "resource_index" / "rosidl_interfaces"
        return (index / package).exists() and not (self._twins / package).exists()

    def build_twins(self, packages: Sequence[pathlib.Path]) -> None:
        """Build and install the twins that are new or changed, and write down their names.

        :param packages: folders of packages, with messages or without
        :raises Unavailable: if a type cannot have a twin, or one does not build
        """
        texts = {**definitions(packages), **WITHOUT_WHEEL}
        try:
            twins = {
                name: generate_interfaces(name, files)
                for name, files in texts.items()
                if files and not self.has_wheel(name)
            }
        except DefinitionError as error:
            raise Unavailable(f"a type cannot have a twin in ROS 2: {error}") from None
        self._build(twins)
        names = dict(RENAMED)
        for twin in twins.values():
            names.update(twin.names)
        self._names.parent.mkdir(parents=True, exist_ok=True)
        self._names.write_text(yaml.safe_dump(names), "utf-8")

    def _build(self, twins: Mapping[str, TwinPackage]) -> None:
        digests: Dict[str, str] = {}
        stale = []
        for name in in_order(twins):
            parts = [f"{path}\0{text}" for path, text in sorted(twins[name].files.items())]
            parts += [digests.get(needed, "") for needed in sorted(twins[name].needs)]
            parts += [BUILDER.read_text("utf-8")]
            digests[name] = hashlib.sha256("\0".join(parts).encode()).hexdigest()
            stamp = self._twins / name / "stamp"
            if not stamp.exists() or stamp.read_text("utf-8") != digests[name]:
                stale.append(name)
                self._write_source(name, twins[name])
        if not stale:
            return
        if self._names.exists():
            self._names.unlink()
        began = time.monotonic()
        given = [f"{name}:{','.join(sorted(twins[name].needs))}" for name in stale]
        command = [str(self._python), str(BUILDER), str(self._twins), *given]
        self.run(command, BUILD_LIMIT_S, "the ROS 2 twins do not build")
        for name in stale:
            (self._twins / name / "stamp").write_text(digests[name], "utf-8")
        took = time.monotonic() - began
        say(f"built the ROS 2 twins of {', '.join(stale)} in {took:.0f} s")

    def _write_source(self, name: str, twin: TwinPackage) -> None:
        """Replace the definitions of a package of twins."""
        shutil.rmtree(str(self._twins / name), ignore_errors=True)
        for path, text in twin.files.items():
            target = self._twins / name / "source" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, "utf-8")


def first_error(log: str) -> str:
    """Return from the output of a command that has failed what says why."""
    if "connection broken by" in log:  # pip's, before it says that there is no such package
        return "no connection"
    lines = log.splitlines() or ["it wrote nothing"]
    errors = [line for line in lines if "error" in line.lower()] or lines[-1:]
    return errors[0].strip()


def check_python() -> None:
    """Refuse a Python that there are no wheels for."""
    if sys.version_info[:2] not in PYTHONS:
        known = ", ".join("%d.%d" % version for version in PYTHONS)
        mine = "%d.%d" % sys.version_info[:2]
        raise Unavailable(f"PyPI has ROS 2 for Python {known} only, and this is {mine}")


def definitions(packages: Sequence[pathlib.Path]) -> Dict[str, Dict[str, str]]:
    """Return the definitions of each package, text by path within it."""
    return {
        package.name: {
            str(path.relative_to(package)): path.read_text("utf-8")
            for kind in ("msg", "srv", "action")
            for path in sorted(package.glob(f"{kind}/*.{kind}"))
        }
        for package in packages
    }


def companions(package: pathlib.Path) -> List[pathlib.Path]:
    """Return the packages beside one that have the same maintainer: those it was installed with."""

    def maintainer(folder: pathlib.Path) -> str:
        return ElementTree.parse(str(folder / "package.xml")).findtext("maintainer", "")

    folders = [manifest.parent for manifest in sorted(package.parent.glob("*/package.xml"))]
    return [folder for folder in folders if maintainer(folder) == maintainer(package)]


def in_order(twins: Mapping[str, TwinPackage]) -> List[str]:
    """Return the names so that each stands behind those that it needs."""
    names: List[str] = []

    def add(name: str) -> None:
        for needed in sorted(twins[name].needs):
            if needed in twins:
                add(needed)
        if name not in names:
            names.append(name)

    for name in sorted(twins):
        add(name)
    return names


def main() -> int:
    """Make what is missing.

    :returns: exit status
    """
    package = pathlib.Path(rospkg.RosPack().get_path("ros2_bridge"))
    parser = argparse.ArgumentParser(
        prog="make_environment",
        description="Make the Python environment with ROS 2 that the bridge runs in.",
    )
    parser.add_argument(
        "--into",
        metavar="FOLDER",
        type=pathlib.Path,
        default=home(os.environ),
        help="where to make it (default: %(default)s)",
    )
    parser.add_argument(
        "--sources",
        metavar="FOLDER",
        type=pathlib.Path,
        help="make twins for all packages there, not for those installed with the bridge",
    )
    options = parser.parse_args()
    packages = companions(package)
    if options.sources:
        packages = [manifest.parent for manifest in sorted(options.sources.glob("*/package.xml"))]
    environment = PythonEnvironment(options.into.absolute())
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        environment.fetch(package / "config" / "wheels.txt")
        environment.build_twins(packages)
    except Unavailable as reason:
        say(str(reason))
        return 125
    except KeyboardInterrupt:
        say("interrupted: it has to be run again")
        return 130
    return 0
