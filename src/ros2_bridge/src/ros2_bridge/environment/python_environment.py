"""Creation and update of the Python environment with ROS 2.

Twins are ROS 2 packages with the types of ROS 1 packages: :mod:`ros2_bridge.types.ros2_interfaces`.
"""

import contextlib
import fcntl
import hashlib
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import time
from typing import Dict, Iterator, List, Mapping, Sequence
from xml.etree import ElementTree

import yaml

from ros2_bridge.environment.start import DEBIAN
from ros2_bridge.types.ros2_interfaces import RENAMED, TwinPackage, generate_interfaces

#: Python versions with wheels.
PYTHONS = ((3, 11), (3, 12), (3, 13), (3, 14))
#: Architectures with wheels, as ``uname -m`` names them.
MACHINES = ("x86_64",)
#: ROS 1 packages that exist in ROS 2 but not on PyPI: their bridged types.
WITHOUT_WHEEL = {
    "tf2_msgs": {"msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n"},
}
#: Timeouts for creating the environment, for downloads from PyPI, and for building all packages
#: [s]; ten times the usual duration, for busy machines.
VENV_LIMIT_S, FETCH_LIMIT_S, BUILD_LIMIT_S = 300.0, 900.0, 900.0
#: Marks a folder that this command created, and may remove.
MARK = "made_by_ros2_bridge"
#: Debian's folder of message definitions.
SHARE = pathlib.Path("/usr/share")
BUILDER = pathlib.Path(__file__).with_name("twin_builder.py")


class Unavailable(Exception):
    """Error of an environment that cannot be created; the text gives the cause."""


def say(text: str) -> None:
    print(f"make_environment: {text}", file=sys.stderr, flush=True)


class PythonEnvironment:
    """Python environment with ROS 2.

    :param folder: its folder; the sources of the twins are beside it

    :ivar python: its interpreter
    """

    def __init__(self, folder: pathlib.Path) -> None:
        self.folder = folder
        self.python = folder / "bin" / "python"
        self._twins = folder.with_name(f"{folder.name}_twins")
        #: The previous environment, until the new one is complete.
        self._previous = folder.with_name(f"{folder.name}_previous")
        #: Written last: marks a complete environment.
        self._names = folder / "share" / "ros2_bridge" / "names.yaml"
        self._left_out = self._names.with_name("left_out.yaml")

    def make(self, wheels: pathlib.Path, packages: Mapping[str, pathlib.Path]) -> None:
        """Create or update the environment; keep the existing one until a new one is complete.

        :param wheels: list of the wheels
        :param packages: folders of packages, with or without messages, by name
        :raises Unavailable: on failure
        """
        self._claim()
        with self.locked():
            self._make(wheels, packages)

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Exclude other commands that change this environment; wait for them."""
        with open(self._twins / "lock", "w", encoding="utf-8") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                say(f"another command is changing {self.folder}: waiting for it")
                fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def _make(self, wheels: pathlib.Path, packages: Mapping[str, pathlib.Path]) -> None:
        self._restore()
        stamp = self.folder / "wheels"
        wanted = f"{self.folder}\n{sys.version}\n{wheels.read_text('utf-8')}"
        if stamp.exists() and stamp.read_text("utf-8") == wanted and self._names.exists():
            self.build_twins(packages)
            return
        check_platform()
        say(f"fetching ROS 2 from PyPI, once, into {self.folder}")
        if self.folder.exists():
            self.folder.rename(self._previous)
        try:
            self._mark(self.folder)
            self._install(wheels)
            stamp.write_text(wanted, "utf-8")
            for built in self._twins.glob("*/stamp"):
                built.unlink()
            self.build_twins(packages)
        except BaseException:
            self._restore()
            raise
        shutil.rmtree(str(self._previous), ignore_errors=True)

    def _claim(self) -> None:
        """Reject folders with the user's files, and mark the others.

        :raises Unavailable: if a folder is not empty and was not created by this command
        """
        earlier = (
            self.folder / "share" / "ros2_bridge"
        ).is_dir()  # by an older release, without marks
        for place in (self.folder, self._twins, self._previous):
            empty = not place.exists() or (place.is_dir() and not any(place.iterdir()))
            if not (empty or earlier or (place / MARK).exists()):
                raise Unavailable(
                    f"{place} is not empty and was not created by this command;"
                    " name a new or an empty folder with --into"
                )
        self._mark(self._twins)
        if earlier:
            self._mark(self.folder)

    def _mark(self, place: pathlib.Path) -> None:
        place.mkdir(parents=True, exist_ok=True)
        (place / MARK).touch()

    def _restore(self) -> None:
        """Restore the previous environment unless the new one is complete."""
        if not self._names.exists():
            shutil.rmtree(str(self.folder), ignore_errors=True)
            if self._previous.exists():
                self._previous.rename(self.folder)
        shutil.rmtree(str(self._previous), ignore_errors=True)

    def run(self, command: Sequence[str], limit: float, what: str) -> None:
        """Run a command of the environment, without ROS 1, with its output in a log file.

        :param limit: timeout [s]
        :param what: description of a failure, for the message
        :raises Unavailable: if it fails
        """
        log = self._twins / "log"
        variables = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
        }
        variables["PATH"] = f"{self.folder / 'bin'}:{variables['PATH']}"
        variables["AMENT_PREFIX_PATH"] = variables["CMAKE_PREFIX_PATH"] = str(self.folder)
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

    def _install(self, wheels: pathlib.Path) -> None:
        venv = ["/usr/bin/python3", "-m", "venv", str(self.folder)]
        self.run(venv, VENV_LIMIT_S, "cannot make a virtual environment")
        # --no-deps: our list is complete, while the dependency lists of the wheels are not.
        # --no-compile: only a tenth of the modules are ever imported.
        pip = [str(self.python), "-m", "pip", "install", "--no-deps", "--no-compile", "--quiet"]
        pip += ["--retries", "1", "--disable-pip-version-check", "--only-binary", ":all:"]
        # empy has only a source archive: it is built with a setuptools of known hash, too.
        builds_empy = ["--no-binary", "empy", "--no-build-isolation"]
        for options in (
            ["--requirement", str(wheels.with_name("build_tools.txt"))],
            [*builds_empy, "--requirement", str(wheels)],
        ):
            self.run([*pip, *options], FETCH_LIMIT_S, "ROS 2 cannot be installed from PyPI")

    def _has_wheel(self, package: str) -> bool:
        """Return whether a wheel contains the ROS 2 package of this name."""
        return self._index(package).exists() and not (self._twins / package).exists()

    def _index(self, package: str) -> pathlib.Path:
        share = self.folder / "share" / "ament_index" / "resource_index"
        return share / "rosidl_interfaces" / package

    def _is_in_wheel(self, message: str) -> bool:
        """Return whether a wheel contains a message, such as ``std_msgs/Header``."""
        package, _, name = message.partition("/")
        if not self._has_wheel(package):
            return False
        return f"msg/{name}.idl" in self._index(package).read_text("utf-8").split()

    def build_twins(self, packages: Mapping[str, pathlib.Path]) -> None:
        """Build and install new and changed twins of ROS 1 types, and write their list of names.

        Twins of earlier runs are kept. A type that cannot have a twin is skipped, and reported
        once.

        :param packages: folders of packages, with or without messages, by name
        :raises Unavailable: if the builder does not run
        """
        texts = {**WITHOUT_WHEEL, **self._earlier_definitions(), **definitions(packages)}
        texts = {name: its for name, its in texts.items() if its and not self._has_wheel(name)}
        twins, left_out = generate_interfaces(texts, self._is_in_wheel)
        self._build(twins, texts)
        names = dict(RENAMED)
        for name, twin in twins.items():
            error = self._twins / name / "error"
            if error.exists():
                left_out[name] = error.read_text("utf-8")
            else:
                names.update(twin.names)
        self._names.parent.mkdir(parents=True, exist_ok=True)
        reported = yaml.safe_load(self._left_out.read_text()) if self._left_out.exists() else {}
        for path, reason in sorted(left_out.items()):
            if reported.get(path) != reason:
                say(f"left out {path}: {reason}")
        self._left_out.write_text(yaml.safe_dump(left_out), "utf-8")
        self._names.write_text(yaml.safe_dump(names), "utf-8")

    def _earlier_definitions(self) -> Dict[str, Dict[str, str]]:
        """Return the ROS 1 definitions of the twins that earlier runs built."""
        return {
            path.parent.name: yaml.safe_load(path.read_text("utf-8"))
            for path in sorted(self._twins.glob("*/definitions.yaml"))
        }

    def _build(
        self, twins: Mapping[str, TwinPackage], texts: Mapping[str, Mapping[str, str]]
    ) -> None:
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
                self._write_source(name, twins[name], texts[name])
        if not stale:
            return
        began = time.monotonic()
        given = [f"{name}:{','.join(sorted(twins[name].needs))}" for name in stale]
        command = [str(self.python), str(BUILDER), str(self._twins), *given]
        self.run(command, BUILD_LIMIT_S, "the ROS 2 twins do not build")
        built = [name for name in stale if not (self._twins / name / "error").exists()]
        for name in built:
            (self._twins / name / "stamp").write_text(digests[name], "utf-8")
        if built:
            took = time.monotonic() - began
            say(f"built the ROS 2 twins of {', '.join(built)} in {took:.0f} s")

    def _write_source(self, name: str, twin: TwinPackage, texts: Mapping[str, str]) -> None:
        """Replace the definitions of a twin package."""
        place = self._twins / name
        shutil.rmtree(str(place), ignore_errors=True)
        for path, text in twin.files.items():
            target = place / "source" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, "utf-8")
        (place / "definitions.yaml").write_text(yaml.safe_dump(dict(texts)), "utf-8")


def first_error(log: str) -> str:
    """Return the decisive line of a failed command's output."""
    if "connection broken by" in log:  # from pip, before "no such package"
        return "no connection"
    lines = log.splitlines() or ["it wrote nothing"]
    errors = [line for line in lines if re.search("error|^fatal:", line, re.IGNORECASE)]
    errors = errors or lines[-1:]
    return errors[0].strip()


def check_platform() -> None:
    """Reject an architecture or a Python version without wheels."""
    if platform.machine() not in MACHINES:
        raise Unavailable(
            f"PyPI has ROS 2 only for {', '.join(MACHINES)} (this machine: {platform.machine()});"
            " start the bridge on one of those, with ROS_MASTER_URI set to this machine's master"
        )
    if sys.version_info[:2] not in PYTHONS:
        known = ", ".join("%d.%d" % version for version in PYTHONS)
        mine = "%d.%d" % sys.version_info[:2]
        raise Unavailable(f"PyPI has ROS 2 for Python {known} only, and this is {mine}")


def definitions(packages: Mapping[str, pathlib.Path]) -> Dict[str, Dict[str, str]]:
    """Return the definitions of each package, text by path within it."""
    return {
        name: {
            str(path.relative_to(folder)): _read(path)
            for kind in ("msg", "srv", "action")
            for path in sorted(folder.glob(f"{kind}/*.{kind}"))
        }
        for name, folder in packages.items()
    }


def _read(path: pathlib.Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:  # usually an old comment with a degree sign
        return data.decode("latin-1")


def companions(package: pathlib.Path) -> Dict[str, pathlib.Path]:
    """Return the packages beside a package that have the same maintainer: installed together."""

    def maintainer(folder: pathlib.Path) -> str:
        return ElementTree.parse(str(folder / "package.xml")).findtext("maintainer", "")

    folders = [manifest.parent for manifest in sorted(package.parent.glob("*/package.xml"))]
    return {folder.name: folder for folder in folders if maintainer(folder) == maintainer(package)}


def packages_under(folder: pathlib.Path) -> Dict[str, pathlib.Path]:
    """Return the packages in a folder at any depth, as catkin finds them.

    A package whose package.xml cannot be read is skipped, with a message. So are all packages of
    the same name but the first, in alphabetical order of the paths.
    """
    found: Dict[str, pathlib.Path] = {}
    for place, folders, files in os.walk(str(folder), followlinks=True):
        folders.sort()
        if "CATKIN_IGNORE" in files:
            folders.clear()
        elif "package.xml" in files:
            folders.clear()
            manifest = pathlib.Path(place, "package.xml")
            try:
                name = ElementTree.parse(str(manifest)).findtext("name", "").strip()
            except ElementTree.ParseError as error:
                say(f"{manifest}: invalid XML ({error}); the package is skipped")
            except (OSError, ValueError) as error:  # e.g. a broken link or an unknown encoding
                say(f"{manifest}: {error}; the package is skipped")
            else:
                if not name:
                    say(f"{manifest}: missing name; the package is skipped")
                elif found.setdefault(name, manifest.parent) != manifest.parent:
                    say(f"{manifest}: same name as {found[name]}; the package is skipped")
    return found


def debian_packages(share: pathlib.Path = SHARE, modules: str = DEBIAN) -> Dict[str, pathlib.Path]:
    """Return the message packages that Debian has installed.

    A package with Python code besides its messages is omitted: its twin would hide that code.
    """
    found = {}
    for folder in sorted(
        {path.parent for kind in ("msg", "srv") for path in share.glob(f"*/{kind}")}
    ):
        code = {path.name for path in pathlib.Path(modules, folder.name).glob("*")}
        if code and code <= {"__init__.py", "__pycache__", "msg", "srv"}:
            found[folder.name] = folder
    return found


def in_order(twins: Mapping[str, TwinPackage]) -> List[str]:
    """Return the names in dependency order."""
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
