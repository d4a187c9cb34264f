"""Tests of the judge's errors before it starts a process."""

import pathlib
import sys
from typing import List

import pytest

from pid_control.commands import judge, judging_command

GOOD = str(pathlib.Path(__file__).resolve().parents[1] / "controllers" / "good_loop.py")
SIMULATED = """
<launch>
  <param name="/use_sim_time" value="true"/>
  <node pkg="pid_control" type="controller.py" name="controller"/>
</launch>
"""


@pytest.mark.parametrize(
    "words, says",
    [
        (
            ["--real-plant", "{folder}/simulated.launch"],
            "{folder}/simulated.launch /controller: it sets /use_sim_time",
        ),
        (
            ["--limits", "{folder}/wrong.yaml", "x"],
            "{folder}/wrong.yaml: steps: overshot: not measured there",
        ),
        (["--limits", "nowhere.yaml", "x"], "nowhere.yaml: No such file"),
        ([], "controller missing; give a package and a name in it, or a path"),
        (
            ["no_such_package", "controller.py"],
            "package not found in ROS_PACKAGE_PATH (no_such_package)",
        ),
        (["pid_control", "nothing.py"], "nothing.py: not found in the package pid_control"),
        (["a/b.py"], "file not found (a/b.py)"),
        (["{folder}/controller"], "is not executable: chmod +x {folder}/controller"),
        (["--only", "stairs", "x"], "unknown scenario 'stairs'; choose from held, rate"),
        (["--time-limit", "0", "x"], "'0' must be from 1 to 3600 s"),
        (
            ["--node", "motor", "pid_control", "motor_control.launch"],
            "has no node motor; its nodes are /system",
        ),
        (["--picture", "judged.png", "x"], "'judged.png' does not end in .svg"),
        (["--full-speed", "fast", "x"], "'fast' must be above 0 and at most 1e+06 rad/s"),
        (["--full-speed", "9", "x", "y"], "--full-speed: only valid with --real-plant"),
        (["--real-plant", "--only", "held", GOOD], "held is not for a real plant: there are steps"),
        (["--class", "nowhere"], "--class: not a folder (nowhere)"),
        (["--class", "{folder}"], "no package in {folder}"),
        (["--class", "{folder}", "--csv", "x"], "not valid with --class"),
        (["--csv", "{folder}/no/x.csv", "x", "y"], "{folder}/no/x.csv: No such"),
        (["--csv", "{folder}", "x", "y"], "judge: {folder}: Is a directory"),
        (["--picture", "{folder}/no/x.svg", GOOD], "{folder}/no/x.svg: No such"),
        (["--workspace", "{folder}", "x", "controller.py"], "not a built workspace"),
    ],
)
def test_judge_invalid_request_names_the_problem(
    words: List[str],
    says: str,
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    (tmp_path / "wrong.yaml").write_text("steps: {overshot: 5}\n")
    (tmp_path / "controller").write_text("")
    (tmp_path / "simulated.launch").write_text(SIMULATED)
    before = sorted(tmp_path.iterdir())
    arguments = [word.format(folder=tmp_path) for word in words]
    monkeypatch.setattr(sys, "argv", ["judge", *arguments])
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        judge.main()
    output, errors = capsys.readouterr()
    assert end.value.code == 125 and says.format(folder=tmp_path) in output + errors
    assert sorted(tmp_path.iterdir()) == before
