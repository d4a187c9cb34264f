"""Tests of ci/deb: commands of its page, and dependencies of its packages.

Course 002-pkg-12.
"""

import pathlib
import subprocess
from typing import List

import pytest

from .conftest import CI

INSIDE = CI / "packages" / "deb-inside.bash"


def inside(script: str, *arguments: str) -> List[str]:
    """Return the output of a script that may call the functions of ci/deb."""
    command = ["bash", "-c", f"source '{INSIDE}'; {script}", "bash", *arguments]
    return subprocess.check_output(command, timeout=30).decode().splitlines()


def test_the_commands_are_those_of_the_page() -> None:
    install, launch = inside("page_commands docs/packaging.md Install")
    assert install == "sudo apt install ./*.deb"
    proof = (CI / "packages" / "deb_proof.py").read_text("utf-8")
    assert (
        f"running({', '.join(f'{word!r}' for word in launch.split())})".replace("'", '"') in proof
    )


@pytest.mark.parametrize(
    "options, said",
    [
        (["--only", "bake"], "unknown part 'bake': must be one of build, prove, bridge."),
        (["--only"], "--only takes a name"),
        (["--only", ","], "--only takes a name"),
        (["sid"], "unknown suite 'sid'"),
        (["bookworm", "--only", "bake"], "unknown part 'bake'"),
        (["--other"], "Usage: ci/deb"),
    ],
)
def test_unknown_options_are_refused(options: List[str], said: str) -> None:
    result = subprocess.run(
        [str(CI / "deb"), *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60
    )
    assert result.returncode == 125
    assert said in result.stdout.decode()


@pytest.mark.parametrize("script", ["packages/deb-inside", "systems/clean-room-inside"])
def test_each_part_has_a_line_and_any_failure_decides(script: str) -> None:
    options = "build,prove bookworm" if "deb" in script else "build,prove '' bookworm"
    command = (
        f"source '{CI}/{script}.bash'; find_mirror() {{ :; }}; "
        'with_system() { verdict="$3 of $1"; [[ $good == *"$2"* ]]; }; '
        f"main /nowhere {options}"
    )
    for good, status in (("build", 1), ("prove", 1), ("build prove", 0)):
        result = subprocess.run(
            ["bash", "-c", f"good='{good}'; {command}"],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=30,
        )
        assert result.returncode == status
        lines = [line.split(maxsplit=3) for line in result.stdout.decode().splitlines()]
        assert lines == [
            ["ok" if part in good else "FAILED", "bookworm", part, f"take_{part} of bookworm"]
            for part in ("build", "prove")
        ]


def test_packages_missing_in_dist_are_reported(tmp_path: pathlib.Path) -> None:
    stubs = "; ".join(
        f"{name}() {{ :; }}" for name in "apt_get succeeds git tar python3 chroot cp".split()
    )
    furnish = 'furnish() { mkdir -p "$1/home/student"; }; within() { echo 1; }'
    build = 'dist=$1/dist commit=it; take_build bookworm "$1" 2>/dev/null && echo good || echo bad'
    assert inside(f"{stubs}; {furnish}; {build}", str(tmp_path / "one")) == ["good"]
    full = "cp() { return 1; }"  # as on a disk that is full
    assert inside(f"{stubs}; {full}; {furnish}; {build}", str(tmp_path / "two")) == ["bad"]


def test_dependencies_on_each_other_are_left_out(tmp_path: pathlib.Path) -> None:
    for name in ("a", "b"):
        tree = tmp_path / name
        (tree / "DEBIAN").mkdir(parents=True)
        (tree / "DEBIAN" / "control").write_text(
            f"Package: {name}\nVersion: 1\nArchitecture: all\nMaintainer: me <me@example.org>\n"
            f"Depends: ours-{name} (= 1), theirs, python3:any\nDescription: {name}\n"
        )
        command = ["dpkg-deb", "--root-owner-group", "--build", str(tree)]
        subprocess.check_call(command, stdout=subprocess.DEVNULL, timeout=30)
    debs = [str(tmp_path / name) for name in ("a.deb", "b.deb")]
    assert inside('foreign Depends "$@"', *debs) == ["python3:any,theirs"]
