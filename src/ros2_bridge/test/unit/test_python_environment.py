"""make_environment says in one sentence why it fails, and builds twins in order."""

import pathlib
import sys
from typing import List, Sequence

import pytest

from ros2_bridge.environment import python_environment
from ros2_bridge.environment.python_environment import PythonEnvironment, Unavailable
from ros2_bridge.types.ros2_interfaces import generate_interfaces


def test_another_python_is_refused(
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    tmp_path: pathlib.Path,
) -> None:
    monkeypatch.setattr(python_environment, "PYTHONS", ((3, 2),))
    monkeypatch.setattr(sys, "argv", ["make_environment", "--into", str(tmp_path / "ros2")])
    assert python_environment.main() == 125
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("make_environment: PyPI has ROS 2 for Python 3.2 only, and this is 3.")


def test_first_error_of_a_command_is_the_reason(tmp_path: pathlib.Path) -> None:
    ours = PythonEnvironment(tmp_path / "ros2")
    noise = "echo collecting; echo 'ERROR: No matching distribution found'; echo bye; exit 1"
    with pytest.raises(Unavailable, match="no wheels: ERROR: No matching"):
        ours.run(["sh", "-c", noise], 10.0, "no wheels")
    with pytest.raises(Unavailable, match="no wheels: it wrote nothing"):
        ours.run(["false"], 10.0, "no wheels")
    with pytest.raises(Unavailable, match="not finished within 0.1 s"):
        ours.run(["sleep", "10"], 0.1, "no wheels")


def test_without_a_network_that_is_the_reason() -> None:
    retry = "WARNING: Retrying after connection broken by 'NewConnectionError(…)': /simple/x/"
    log = f"{retry}\nERROR: No matching distribution found for x==1.0\n"
    assert python_environment.first_error(log) == "no connection"


@pytest.mark.parametrize("script", ["exit 1", "kill -INT $PPID; sleep 9"])
def test_nothing_half_made_stays(
    script: str, monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    monkeypatch.setattr(python_environment, "PYTHONS", (sys.version_info[:2],))
    wheels = tmp_path / "wheels.txt"
    wheels.write_text("x==1.0\n")
    ours = PythonEnvironment(tmp_path / "ros2")

    def install(_: pathlib.Path) -> None:
        (tmp_path / "ros2").mkdir()
        ours.run(["sh", "-c", script], 10.0, "no wheels")

    monkeypatch.setattr(ours, "_install", install)
    with pytest.raises((Unavailable, KeyboardInterrupt)):
        ours.fetch(wheels)
    assert not (tmp_path / "ros2").exists()
    script = "exit 0"
    ours.fetch(wheels)
    assert (tmp_path / "ros2" / "wheels").exists()


def test_commands_run_without_ros_1(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    monkeypatch.setenv("PYTHONPATH", "/somewhere")
    command = ["sh", "-c", 'test -z "$PYTHONPATH$ROS_DISTRO"']
    PythonEnvironment(tmp_path / "ros2").run(command, 10.0, "it sees ROS 1")


def test_what_another_package_needs_comes_first() -> None:
    uses = {"a": "b/X x\n", "b": "c/X x\n", "c": "uint8 x\n"}
    twins = {name: generate_interfaces(name, {"msg/X.msg": text}) for name, text in uses.items()}
    assert python_environment.in_order(twins) == ["c", "b", "a"]


def test_twins_are_built_once_and_again_where_they_are_new_or_use_what_has_changed(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    ours, built = PythonEnvironment(tmp_path / "ros2"), []

    def run(command: Sequence[str], *_: object) -> None:
        built.append([word.partition(":")[0] for word in command[3:]])

    def build(**definitions: str) -> List[str]:
        """Return the packages whose twins are built, of types X."""
        built.clear()
        ours._build(
            {one: generate_interfaces(one, {"msg/X.msg": it}) for one, it in definitions.items()}
        )
        return built[0] if built else []

    monkeypatch.setattr(ours, "run", run)
    assert build(a="b/X x\n", b="uint8 x\n") == ["b", "a"]
    assert build(a="b/X x\n", b="uint8 x\n") == [] == built
    assert build(a="b/X x\n", b="uint8 x\n", c="uint8 x\n") == ["c"]
    assert build(a="b/X x\n", b="uint8 y\n", c="uint8 x\n") == ["b", "a"]


def test_packages_of_one_maintainer_belong_together(tmp_path: pathlib.Path) -> None:
    for name, maintainer in (("bridge", "we"), ("a_msgs", "we"), ("std_msgs", "others")):
        (tmp_path / name / "msg").mkdir(parents=True)
        (tmp_path / name / "msg" / "X.msg").write_text("uint8 x\n")
        (tmp_path / name / "package.xml").write_text(
            f"<package><maintainer>{maintainer}</maintainer></package>"
        )
    found = python_environment.companions(tmp_path / "bridge")
    assert [folder.name for folder in found] == ["a_msgs", "bridge"]
    assert python_environment.definitions(found)["a_msgs"] == {"msg/X.msg": "uint8 x\n"}
