"""Tests of the clean room: README's commands, and the tiers of each Debian release."""

import os
import pathlib
import subprocess

import pytest

from .conftest import CI, Workspace

INSIDE = CI / "systems" / "clean-room-inside.bash"
#: Two bootstraps, each of a Debian with one file; nothing is mounted.
BOOTSTRAPS = """
set -euo pipefail
me=test room=$1 mirror=none log=/dev/null CLEAN_ROOM_CACHE=$1/cache
source "$0"
copy_apt_settings() { :; }
copy_pip_settings() { return 1; }
debootstrap() { echo "made for ${3##*/}" >"$3/issue"; }
tar() { # the first one is overtaken by another run, whole
    case $#$FIRST in
        5overtaken)
            FIRST=
            command tar -C "$2" -cf "$room/whole" .
            exec 5>"$4"
            head -c 1000 "$room/whole" >&5
            bootstrap trixie "$room/other" || :
            tail -c +1001 "$room/whole" >&5
            ;;
        5fails)
            FIRST=
            : >"$4"
            return 1
            ;;
        *) command tar "$@" ;;
    esac
}
for name in one two; do bootstrap trixie "$room/$name" || :; done
ls "$CLEAN_ROOM_CACHE"
command tar -tf "$CLEAN_ROOM_CACHE/trixie.tar"
cat "$room/two/issue"
"""


def test_the_commands_are_those_of_readme() -> None:
    script = f"source '{INSIDE}'; page_commands README.md 'Two commands'"
    lines = subprocess.check_output(["bash", "-c", script]).decode().splitlines()
    assert lines == ["./ci/exec roslaunch basic_comms cw1.launch", "./ci/test"]
    readme = (CI.parent / "README.md").read_text("utf-8")
    assert all(f"\n{line}  " in readme for line in lines)


@pytest.mark.parametrize(
    "options, said",
    [
        (["--only", "launch,lunch"], "unknown part 'lunch'"),
        (["--only"], "--only takes a name"),
        (["--only", ","], "--only takes a name"),
        (["--tiers"], "--tiers takes a name"),
        (["--other"], "Usage: ci/clean-room"),
    ],
)
def test_clean_room_refuses_unknown_options(options: list, said: str) -> None:
    result = subprocess.run(
        [str(CI / "clean-room"), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=60,
    )
    assert result.returncode == 125
    assert said in result.stdout.decode()


@pytest.mark.parametrize(
    "release, more",
    [("bookworm", " lint docs"), ("trixie", "")],
)
def test_lint_runs_only_with_the_tools_of_the_release(
    workspace: Workspace, release: str, more: str
) -> None:
    workspace.pretend_packages("[run]\none\n[catkin_build]\ntwo\n", installed="one\ntwo\n")
    workspace.pretend_release(release)
    workspace.program = "test"
    command = workspace.root / "ci" / "tiers" / "command.py"
    command.write_text("import sys\nprint(*sys.argv[1:])\n")
    result = workspace.run()
    assert (result.stdout, result.returncode) == ("--without lint\n", 0)
    assert workspace.run("docs").stdout == "docs --without lint\n"
    (workspace.root / "build" / "lint").mkdir()
    requirement = (workspace.root / "ci" / "lint" / "requirements.txt").read_text()
    (workspace.root / "build" / "lint" / "made").write_text(requirement)
    result = workspace.run("all")
    words = "ci unit install catkin_build integration extended ros2" + more
    assert result.stdout == words + ("" if more else " --without lint") + "\n"
    assert ("without lint and docs on a Debian" in result.stderr) == (not more)


@pytest.mark.parametrize("first, kept", [("overtaken", "one"), ("fails", "two")])
def test_run_does_not_change_the_system_kept_by_another(
    tmp_path: pathlib.Path, first: str, kept: str
) -> None:
    (tmp_path / "cache").mkdir()
    system = str(CI / "systems" / "clean-system.bash")
    done = subprocess.run(
        ["bash", "-c", BOOTSTRAPS, system, str(tmp_path)],
        env=dict(os.environ, FIRST=first),
        stdout=subprocess.PIPE,
        universal_newlines=True,
        timeout=60,
    )
    assert done.stdout.splitlines() == ["trixie.tar", "./", "./issue", f"made for {kept}"]
