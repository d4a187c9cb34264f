"""The clean room runs README's commands as they are written, and ci/test suits each release."""

import subprocess

import pytest
from conftest import CI, Workspace

INSIDE = CI / "lib" / "systems" / "clean-room-inside.bash"


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
        (["--only"], "--only takes names"),
        (["--only", ","], "--only takes names"),
        (["--tiers"], "--tiers takes names"),
        (["--other"], "Usage: ci/clean-room"),
    ],
)
def test_the_clean_room_refuses_what_it_does_not_know(options: list, said: str) -> None:
    result = subprocess.run(
        [str(CI / "clean-room"), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=10,
    )
    assert result.returncode == 125
    assert said in result.stdout.decode()


@pytest.mark.parametrize(
    "release, tiers",
    [
        ("bookworm", "lint docs unit install catkin_build integration"),
        ("trixie", "unit install catkin_build integration"),
    ],
)
def test_without_a_tier_all_run_that_the_release_has_tools_for(
    workspace: Workspace, release: str, tiers: str
) -> None:
    workspace.pretend_packages("[run]\none\n[catkin_build]\ntwo\n", installed="one\ntwo\n")
    workspace.pretend_release(release)
    workspace.program = "test"
    run_tiers = workspace.root / "ci" / "lib" / "tiers" / "run_tiers.py"
    run_tiers.write_text("import sys\nprint(*sys.argv[1:])\n")
    result = workspace.run()
    assert (result.stdout, result.returncode) == (tiers + "\n", 0)
    assert ("the tiers for a Debian are: " + tiers in result.stderr) == (release != "bookworm")
    assert workspace.run("docs").stdout == "docs\n"
    assert workspace.run("all").stdout == tiers + " ros2\n"
