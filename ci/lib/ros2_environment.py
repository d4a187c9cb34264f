"""Make the Python environment with ROS 2 in build/ros2, as far as it is not there: see ci/ros2.

Ends with status 125 and one sentence where it cannot be had.
"""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import time
from typing import Dict, List, Mapping, Sequence

import yaml

from ros2_bridge.definitions import DefinitionError
from ros2_bridge.twins import RENAMED, Twin, make_twin

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SOURCES = WORKSPACE / "src"
WHEELS = WORKSPACE / "ci" / "ros2-wheels.txt"
BUILDER = WORKSPACE / "ci" / "lib" / "ros2_twins.py"
ENVIRONMENT = WORKSPACE / "build" / "ros2"
PYTHON = ENVIRONMENT / "bin" / "python"
TWINS = WORKSPACE / "build" / "ros2_twins"

#: Versions of Python that the wheels are for.
PYTHONS = ((3, 11), (3, 12), (3, 13))
#: ROS 1's own packages that ROS 2 has and PyPI has not: what is bridged of them.
WITHOUT_WHEEL = {
    "tf2_msgs": {"msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n"},
}
#: Longest time for what is fetched from PyPI, and for building all packages, s.
FETCH_LIMIT_S, BUILD_LIMIT_S = 900.0, 600.0


class Unavailable(Exception):
    """The environment cannot be had; the text says why."""


def say(text: str) -> None:
    print(f"ci/ros2: {text}", file=sys.stderr, flush=True)


def run(command: Sequence[str], limit: float, what: str) -> None:
    """Run a command of the environment, without ROS 1, and with its output in a log.

    :param limit: longest time, s
    :param what: what it does, for the sentence if it fails
    :raises Unavailable: if it fails
    """
    log = ENVIRONMENT.with_name("ros2.log")
    variables = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
    }
    variables["PATH"] = f"{ENVIRONMENT / 'bin'}:{variables['PATH']}"
    variables["AMENT_PREFIX_PATH"] = variables["CMAKE_PREFIX_PATH"] = str(ENVIRONMENT)
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
        raise Unavailable(f"{what}: not done within {limit:g} s") from None
    except (OSError, subprocess.CalledProcessError):
        lines = log.read_text("utf-8", "replace").splitlines() or ["no word why"]
        errors = [line for line in lines if "error" in line.lower()] or lines[-1:]
        raise Unavailable(f"{what}: {errors[0].strip()} (see {log})") from None


def judge_python() -> None:
    """Refuse a Python that there are no wheels for."""
    if sys.version_info[:2] not in PYTHONS:
        known = ", ".join("%d.%d" % version for version in PYTHONS)
        mine = "%d.%d" % sys.version_info[:2]
        raise Unavailable(f"PyPI has ROS 2 for Python {known}, and this is {mine}")


def make_environment() -> None:
    """Install the wheels, unless just these are installed."""
    stamp = ENVIRONMENT / "wheels"
    wanted = f"{ENVIRONMENT}\n{sys.version}\n{WHEELS.read_text('utf-8')}"
    if stamp.exists() and stamp.read_text("utf-8") == wanted:
        return
    judge_python()
    say("fetching ROS 2 from PyPI, once, into build/ros2")
    for place in (ENVIRONMENT, TWINS):
        shutil.rmtree(str(place), ignore_errors=True)
    run(["/usr/bin/python3", "-m", "venv", str(ENVIRONMENT)], 60.0, "no virtual environment")
    # Their own lists are incomplete, so ours is complete, and pip need not ask for theirs.
    # Python compiles what is imported, which is a tenth of all, when it is.
    pip = [str(PYTHON), "-m", "pip", "install", "--no-deps", "--no-compile", "--quiet"]
    options = ["--retries", "1", "--disable-pip-version-check", "--requirement", str(WHEELS)]
    run([*pip, *options], FETCH_LIMIT_S, "ROS 2 cannot be installed from PyPI")
    stamp.write_text(wanted, "utf-8")


def message_packages() -> Dict[str, Dict[str, str]]:
    """Return the definitions of each package without a wheel, text by path within it."""
    found = {
        manifest.parent.name: {
            str(path.relative_to(manifest.parent)): path.read_text("utf-8")
            for kind in ("msg", "srv")
            for path in sorted(manifest.parent.glob(f"{kind}/*.{kind}"))
        }
        for manifest in sorted(SOURCES.glob("*/package.xml"))
    }
    found.update(WITHOUT_WHEEL)
    return {name: texts for name, texts in found.items() if texts and not has_wheel(name)}


def has_wheel(package: str) -> bool:
    """Tell whether a wheel brings the ROS 2 package of this name."""
    index = ENVIRONMENT / "share" / "ament_index" / "resource_index" / "rosidl_interfaces"
    return (index / package).exists() and not (TWINS / package).exists()


def in_order(twins: Mapping[str, Twin]) -> List[str]:
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


def build_twins() -> None:
    """Build and install the twins that are new or changed, and write down their names."""
    try:
        twins = {name: make_twin(name, texts) for name, texts in message_packages().items()}
    except DefinitionError as error:
        raise Unavailable(f"a message has no twin in ROS 2: {error}") from None
    digests: Dict[str, str] = {}
    stale = []
    for name in in_order(twins):
        parts = [f"{path}\0{text}" for path, text in sorted(twins[name].files.items())]
        parts += [digests.get(needed, "") for needed in sorted(twins[name].needs)]
        parts += [BUILDER.read_text("utf-8")]
        digests[name] = hashlib.sha256("\0".join(parts).encode()).hexdigest()
        stamp = TWINS / name / "stamp"
        if not stamp.exists() or stamp.read_text("utf-8") != digests[name]:
            stale.append(name)
            write_source(name, twins[name])
    if stale:
        began = time.monotonic()
        given = [f"{name}:{','.join(sorted(twins[name].needs))}" for name in stale]
        command = [str(PYTHON), str(BUILDER), str(TWINS), *given]
        run(command, BUILD_LIMIT_S, "the ROS 2 twins do not build")
        for name in stale:
            (TWINS / name / "stamp").write_text(digests[name], "utf-8")
        took = time.monotonic() - began
        say(f"built the ROS 2 twins of {', '.join(stale)} in {took:.0f} s")
    names = dict(RENAMED)
    for twin in twins.values():
        names.update(twin.names)
    target = ENVIRONMENT / "share" / "ros2_bridge" / "names.yaml"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(yaml.safe_dump(names), "utf-8")


def write_source(name: str, twin: Twin) -> None:
    """Write a twin's definitions anew."""
    shutil.rmtree(str(TWINS / name), ignore_errors=True)
    for path, text in twin.files.items():
        target = TWINS / name / "source" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, "utf-8")


def main() -> int:
    """Make what is missing.

    :returns: exit status
    """
    try:
        make_environment()
        build_twins()
    except Unavailable as reason:
        say(str(reason))
        return 125
    return 0


if __name__ == "__main__":
    sys.exit(main())
