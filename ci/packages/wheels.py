"""Choose the wheels of ROS 2 for the bridge: see ci/ros2-wheels.

Ends with status 125 and one sentence where there are none that fit.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
from typing import Any, Dict, Iterable, List, NamedTuple, Set

from ros2_bridge.environment.environment import PYTHONS

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
WANTED = WORKSPACE / "packaging" / "ros2_wheels.txt"
CHOSEN = WORKSPACE / "src" / "ros2_bridge" / "config" / "wheels.txt"
HEADING = """\
# What make_environment fetches from PyPI. Chosen by ./ci/ros2-wheels from the list in
# packaging/ros2_wheels.txt; the hashes are those of the files for each Python.
"""
#: Versions of the C library, 2.N, that wheels may be built for: up to Debian 12's.
LIBRARIES = range(36, 16, -1)
#: Longest time for what pip asks and fetches for one Python, s.
LIMIT_S = 900.0


class Refused(Exception):
    """There are no such wheels; the text says why."""


class Wheel(NamedTuple):
    """A file that pip would install; of empy there is no wheel but a source.

    :param digest: its SHA-256
    """

    package: str
    version: str
    digest: str


def wheels_in(report: Any) -> List[Wheel]:
    """Return what a report of pip says that it would install."""
    return [
        Wheel(
            one["metadata"]["name"],
            one["metadata"]["version"],
            one["download_info"]["archive_info"]["hashes"]["sha256"],
        )
        for one in report["install"]
    ]


def requirements(wheels: Iterable[Wheel]) -> str:
    """Return the list that pip takes, with all hashes of each package."""
    digests: Dict[str, Set[str]] = {}
    for package, version, digest in wheels:
        digests.setdefault(f"{package}=={version}", set()).add(digest)
    lines = []
    for pin in sorted(digests, key=str.lower):
        hashes = [f"    --hash=sha256:{digest}" for digest in sorted(digests[pin])]
        lines.append(" \\\n".join([pin, *hashes]))
    return "\n".join(lines) + "\n"


def pins(text: str) -> Dict[str, str]:
    """Return version by package, as a list for pip names them."""
    named = [line.partition(" ")[0].partition("==") for line in text.splitlines()]
    return {package: version for package, equals, version in named if equals}


def ask_pip(pip: pathlib.Path, python: str, wanted: List[str]) -> List[Wheel]:
    """Return the newest wheels for one Python on amd64.

    :param python: its version, such as 3.11
    :param wanted: requirements
    :raises Refused: if there are none for one of them
    """
    report = pip.parent / "report.json"
    command = [str(pip), "install", "--quiet", "--no-deps", "--dry-run", "--ignore-installed"]
    command += ["--disable-pip-version-check", "--prefer-binary", "--target", str(pip.parent)]
    command += ["--python-version", python, "--implementation", "cp"]
    for minor in LIBRARIES:
        command += ["--platform", f"manylinux_2_{minor}_x86_64"]
    command += ["--report", str(report), *wanted]
    try:
        subprocess.run(command, check=True, capture_output=True, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        raise Refused(f"PyPI has not sent the wheels within {LIMIT_S:g} s") from None
    except subprocess.CalledProcessError as error:
        errors = [line for line in error.stderr.splitlines() if line.startswith("ERROR")]
        why = errors[-1] if errors else error.stderr.strip()
        raise Refused(f"no wheels for Python {python}: {why}") from None
    return wheels_in(json.loads(report.read_text("utf-8")))


def choose(pip: pathlib.Path, wanted: List[str]) -> List[Wheel]:
    """Return the wheels for all Pythons, of each package in one version.

    The oldest Python chooses: newer versions of a package are often for newer Pythons only.
    """
    found: List[Wheel] = []
    for python in sorted(PYTHONS):
        found += ask_pip(pip, "%d.%d" % python, wanted)
        wanted = [f"{one.package}=={one.version}" for one in found]
    return found


def main() -> int:
    """Write the list anew, and print what has changed.

    :returns: exit status
    """
    lines = [line.partition("#")[0].strip() for line in WANTED.read_text("utf-8").splitlines()]
    before = pins(CHOSEN.read_text("utf-8"))
    try:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["/usr/bin/python3", "-m", "venv", folder], check=True)
            pip = pathlib.Path(folder) / "bin" / "pip"
            text = HEADING + "\n" + requirements(choose(pip, [line for line in lines if line]))
    except Refused as reason:
        print(f"ci/ros2-wheels: {reason}", file=sys.stderr)
        return 125
    CHOSEN.write_text(text, "utf-8")
    after = pins(text)
    for package in sorted({*before, *after}, key=str.lower):
        old, new = before.get(package, "not there"), after.get(package, "not there")
        if old != new:
            print(f"{package}: {old} -> {new}")
    pythons = ", ".join("%d.%d" % python for python in PYTHONS)
    place = CHOSEN.relative_to(WORKSPACE)
    print(f"{len(after)} packages, for each Python of {pythons}, are in {place}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
