"""ci/ros2 says in one sentence why there can be no environment, and builds twins in order."""

import pathlib

import pytest
import ros2_environment

from ros2_bridge.twins import make_twin


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path) -> None:
    monkeypatch.setattr(ros2_environment, "ENVIRONMENT", tmp_path / "ros2")
    monkeypatch.setattr(ros2_environment, "TWINS", tmp_path / "twins")


def test_another_python_is_refused(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(ros2_environment, "PYTHONS", ((3, 2),))
    assert ros2_environment.main() == 125
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ci/ros2: PyPI has ROS 2 for Python 3.2, and this is 3.")


def test_first_error_of_a_command_is_the_reason() -> None:
    noise = "echo collecting; echo 'ERROR: No matching distribution found'; echo bye; exit 1"
    with pytest.raises(ros2_environment.Unavailable, match="no wheels: ERROR: No matching"):
        ros2_environment.run(["sh", "-c", noise], 10.0, "no wheels")
    with pytest.raises(ros2_environment.Unavailable, match="no wheels: no word why"):
        ros2_environment.run(["false"], 10.0, "no wheels")
    with pytest.raises(ros2_environment.Unavailable, match="not done within 0.1 s"):
        ros2_environment.run(["sleep", "10"], 0.1, "no wheels")


def test_commands_run_without_ros_1(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setenv("PYTHONPATH", "/somewhere")
    ros2_environment.run(["sh", "-c", 'test -z "$PYTHONPATH$ROS_DISTRO"'], 10.0, "it sees ROS 1")


def test_what_another_package_needs_comes_first() -> None:
    uses = {"a": "b/X x\n", "b": "c/X x\n", "c": "uint8 x\n"}
    twins = {name: make_twin(name, {"msg/X.msg": text}) for name, text in uses.items()}
    assert ros2_environment.in_order(twins) == ["c", "b", "a"]
