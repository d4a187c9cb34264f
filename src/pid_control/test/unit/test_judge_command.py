"""Tests of the judge's errors before it starts a process."""

import os
import pathlib
import sys
from typing import Any, List
from unittest import mock

import pytest

from pid_control.commands import identify, judge, judge_signals, judging_command, tune
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.judging.picture import as_svg
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, MOTOR
from pid_control.runner.judging_errors import JudgingError
from pid_control.verdicts.judgement import Cause, Failure, Finding, Judgement
from pid_control.verdicts.reports import as_csv, as_junit, as_sentences, as_table

#: What a class run judges in each package.
NAMED = ["both.launch", "gain:=2", "--fast"]
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
        (["--time-limit", "3601", "x"], "'3601' must be from 1 to 3600 s"),
        (["--full-speed", "0", "x"], "'0' must be above 0 and at most 1e+06 rad/s"),
        (["--full-speed", "1.1e6", "x"], "'1.1e6' must be above 0 and at most 1e+06 rad/s"),
        (["--roster", "r.csv", "x", "y"], "not judged: --roster: only valid with --class"),
        (["--class", "{folder}", "--node", "n"], "judge: --node: not valid with --class"),
        (
            ["--class", "{folder}", "--workspace", "w"],
            "judge: --workspace: not valid with --class",
        ),
        (
            ["--class", "{folder}", "--picture", "p.svg"],
            "judge: --picture: not valid with --class",
        ),
        (
            ["--class", "{folder}", "--roster", "nowhere.csv"],
            "judge: nowhere.csv: No such file or directory",
        ),
        (["--limits", "{folder}/latin.yaml", "x"], "judge: {folder}/latin.yaml: 'utf-8' codec"),
        (["--time-limit", "long", "x"], "'long' must be from 1 to 3600 s"),
        (
            ["--class", "{folder}", "--roster", "{folder}/roster.csv"],
            "--roster: {folder}/roster.csv: line 1: must be a folder or archive, and a student",
        ),
        (
            ["--node", "motor", "pid_control", "motor_control.launch"],
            "has no node motor; its nodes are /system",
        ),
        (["--picture", "judged.png", "x"], "'judged.png' does not end in .svg"),
        (["--full-speed", "fast", "x"], "'fast' must be above 0 and at most 1e+06 rad/s"),
        (["--output", "{folder}", "x", "y"], "--output: only valid with --class"),
        (["--full-speed", "9", "x", "y"], "--full-speed: only valid with --real-plant"),
        (["--real-plant", "--only", "held", GOOD], "held is not for a real plant: there are steps"),
        (["--class", "nowhere"], "--class: not a folder (nowhere)"),
        (["--class", "{folder}"], "no package in {folder}"),
        (["--class", "{folder}", "--csv", "{folder}/x.csv"], "--csv: not valid with --class"),
        (["--class", "{folder}", "--launch", "x"], "--launch: not valid with --class"),
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
    (tmp_path / "latin.yaml").write_bytes(b"# \xe9\n")
    (tmp_path / "controller").write_text("")
    (tmp_path / "roster.csv").write_text("anna\n")
    (tmp_path / "simulated.launch").write_text(SIMULATED)
    before = sorted(tmp_path.iterdir())
    arguments = [word.format(folder=tmp_path) for word in words]
    monkeypatch.setattr(sys, "argv", ["judge", *arguments])
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        judge.main()
    output, errors = capsys.readouterr()
    assert end.value.code == 125
    assert says.format(folder=tmp_path) in (output + errors).splitlines()[-1]
    assert not ("--limits" in words and output)  # nothing is judged by other limits
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("command", [identify, judge, judge_signals, tune])
def test_version_is_that_of_this_package(
    command: Any, capsys: "pytest.CaptureFixture[str]", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    name = command.__name__.rpartition(".")[2]
    monkeypatch.setattr(sys, "argv", [name, "--version"])
    with pytest.raises(SystemExit):
        command.main()
    assert capsys.readouterr().out.startswith(f"{name} of pid_control ")


def test_judge_help_lists_options_scenarios_and_statuses(
    capsys: "pytest.CaptureFixture[str]", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(sys, "argv", ["judge", "--help"])
    monkeypatch.setenv("COLUMNS", "1000")
    with pytest.raises(SystemExit):
        judge.main()
    output = capsys.readouterr().out
    lines = [" ".join(line.split()) for line in output.splitlines()]
    assert lines[lines.index("scenarios:") :] == [
        "scenarios:",
        "held the motor is held; small and large errors of both signs",
        "rate the motor is held, the clock pauses, and the loop becomes slow",
        "steps up, further up, down and the other way",
        "ramp a ramp",
        "sine a sine of 1 Hz",
        "windup out of reach on either side, and back",
        "noise a noisy measurement",
        "load a load acts on the motor",
        "slower a motor that is slower and weaker than specified",
        "faster a motor that is faster and stronger than specified",
        "missing no output of the motor for 0.2 s",
        "restart the motor is restarted",
        "early the controller starts before the motor",
        "nan NaN as a measurement, and as a set point",
        "",
        "exit status: 0 passed, 1 failed, 125 not judged",
    ]
    own_type = "and its field, if not those of its package or of the course"
    parts = {
        "Judge an unchanged controller of the course's motor, on a private master with a simulated"
        " clock, or with a real plant.",
        "PACKAGE NAME a program or launch file in a package, or its path, followed by its"
        " arguments; with --class, its name in each package, controller.py by default",
        "--node NAME the controller's node in a launch file",
        "--launch FILE launch file with the program's parameters; one of its package by default",
        f"--set-point PACKAGE/TYPE/FIELD type of set_point, {own_type}",
        f"--motor-output PACKAGE/TYPE/FIELD type of motor_output, {own_type}",
        f"--motor-input PACKAGE/TYPE/FIELD type of motor_input, {own_type}",
        "--workspace DIR the controller's built workspace",
        "--limits FILE YAML file of limits",
        "--only NAME,… run these scenarios only",
        "--real-time use the machine's clock, not a simulated one",
        "--time-limit S time limit [s]; 120 by default",
        "--picture FILE.svg draw all scenarios in this file",
        "--csv FILE write all figures to this file",
        "--class DIR judge each package in a folder, and write class.csv and class.html",
        "--roster FILE.csv for --class: rows of a folder or archive, and its student",
        "--output DIR folder for the files of --class; the current one by default",
        "--real-plant use the motor on the current master, in real time",
        "--full-speed RAD/S greatest speed of the real plant [rad/s]; 13 by default",
    }
    assert {part for part in parts if part not in " ".join(output.split())} == set()


def test_judge_rejected_words_of_rostest_and_scenarios_in_their_order() -> None:
    words = ["--gtest_output=xml:a.xml", "x", "__name:=n", "_kp:=1", "__log:=l"]
    assert judging_command._without_rostest(words) == (["x", "_kp:=1"], "a.xml")
    assert judging_command._without_rostest(words[1:]) == (words[1:], None)
    for text, seconds in (("1", 1.0), ("3600", 3600.0)):
        assert judging_command._seconds(text) == seconds
    assert (judge._speed("1e-9"), judge._speed("1e6")) == (1e-9, 1e6)
    names = judging_command.chosen_scenarios("steps,held,steps", ["held", "rate", "steps"])
    assert names == ["held", "steps"]


def test_judge_picture_marks_the_failed_scenario_and_own_limits_replace_some(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    """The words of the controller are not this process's."""
    (tmp_path / "own.yaml").write_text("ramp: {tracking_error: 5}\n")
    judged = mock.Mock()
    failure = Failure("ramp", "too much", Cause("gains", "tune them"))
    finding = Finding("ramp", "tracking_error", 2.0, 1.5, False, "mean |error|", "rad/s")
    judgement = Judgement("failed", [finding], [failure])
    judged.return_value = (judgement, [Record(BY_NAME["ramp"], "ended")])
    monkeypatch.setattr(judge, "_judge", judged)
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    files = ["--picture", str(tmp_path / "a.svg"), "--limits", str(tmp_path / "own.yaml")]
    files += ["--csv", str(tmp_path / "a.csv"), f"--gtest_output=xml:{tmp_path}/a.xml"]
    monkeypatch.setattr(sys, "argv", ["judge", *files, "x", "a:=b"])
    with pytest.raises(SystemExit) as end:
        judge.main()
    assert end.value.code == 1 and sys.argv == ["judge"]
    assert (tmp_path / "a.svg").read_text() == as_svg(judged()[1], "x a:=b: failed", ["ramp"])
    csv = as_csv([("x a:=b", judgement)], SCENARIO_METRICS, "controller")
    assert (tmp_path / "a.csv").read_text() == csv
    assert (tmp_path / "a.xml").read_text() == as_junit(judgement, "x a:=b")
    printed = f"{as_table(judgement)}\n\n{as_sentences(judgement)}\n"
    assert capsys.readouterr().out == printed
    limits = judged.call_args_list[0][0][1]
    assert limits["ramp"]["tracking_error"] == 5.0 and limits["steps"]["overshoot"] == 25.0


def test_class_with_a_name_that_is_not_utf8_is_judged(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    """As from an archive that was made on Windows."""
    command, output = tmp_path / "judge", tmp_path / "out"
    for name in ("Anna", os.fsdecode(b"Jos\xe9"), "Zoe"):
        (tmp_path / "class" / name).mkdir(parents=True)
        (tmp_path / "class" / name / "package.xml").write_text("")
        (tmp_path / "class" / name / "controller.py").write_text("")
    command.write_text("print('judged')")
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    words = ["--class", str(tmp_path / "class"), "--output", str(output)]
    monkeypatch.setattr(sys, "argv", [str(command), *words])
    with pytest.raises(SystemExit) as end:
        judge.main()
    assert end.value.code == 1
    names = ["Anna", "Jos\\udce9", "Zoe"]
    assert [line.partition(":")[0] for line in capsys.readouterr().out.splitlines()] == names
    rows = (output / "class.csv").read_text("utf-8").splitlines()[1:]
    assert [row.partition(",")[0] for row in rows] == names
    assert "<h1>Jos\\udce9</h1>" in (output / "Jos_.html").read_text("utf-8")


def test_judge_prints_the_notes_of_a_judgement_that_fails(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    session, exit_on_signals = mock.Mock(), mock.Mock()
    session.return_value.notes = ["its types are used"]
    session.return_value.judge_with_own_plant.side_effect = JudgingError("no master")
    monkeypatch.setattr("pid_control.runner.session.Session", session)
    monkeypatch.setattr(judging_command, "exit_on_signals", exit_on_signals)
    monkeypatch.setattr(sys, "argv", ["judge", GOOD])
    with pytest.raises(SystemExit) as end:
        judge.main()
    lines = capsys.readouterr().out.splitlines()
    assert end.value.code == 125
    assert lines == [f"judge: {GOOD}", "note: its types are used", "not judged: no master"]
    exit_on_signals.assert_called_once_with()


@pytest.mark.parametrize(
    "words, call",
    [
        ([], mock.call.judge_with_own_plant(False)),
        (["--real-time"], mock.call.judge_with_own_plant(True)),
        (["--real-plant"], mock.call.judge_with_real_plant(MOTOR.max_output)),
        (["--real-plant", "--full-speed", "9"], mock.call.judge_with_real_plant(9.0)),
    ],
)
def test_judge_uses_the_chosen_plant_and_its_options(
    words: List[str], call: Any, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    session = mock.Mock()
    session.return_value.notes, passed = [], Judgement("passed", [], [])
    session.return_value.judge_with_own_plant.return_value = passed
    session.return_value.judge_with_real_plant.return_value = passed
    monkeypatch.setattr("pid_control.runner.session.Session", session)
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    options = ["--only", "ramp", "--time-limit", "9", "--set-point", "std_msgs/Float32/data"]
    monkeypatch.setattr(sys, "argv", ["judge", *options, *words, GOOD])
    with pytest.raises(SystemExit) as end:
        judge.main()
    assert end.value.code == 0 and session.return_value.method_calls == [call]
    command, only, limits, time_limit, types = session.call_args[0]
    assert (command.name, only, time_limit) == (GOOD, [BY_NAME["ramp"]], 9.0)
    assert types == {"set_point": "std_msgs/Float32/data"} and limits["steps"]["overshoot"] == 25.0


@pytest.mark.parametrize(
    "command, words",
    [
        (judge, ["--only", "ramp", "--real-time"]),
        (judge, ["--real-plant", "--full-speed", "9.5", "--motor-input", "std_msgs/Float32/data"]),
        (judge_signals, ["--only", "yaml", "--real-time"]),
        (judge_signals, ["--nodes", "a.py,b.py", "--signal", "/x/data", "--proc-signal", "/y/u"]),
    ],
)
def test_class_gives_each_judgement_its_options(
    command: Any,
    words: List[str],
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    limits = tmp_path / "limits.yaml"
    limits.write_text("")
    monkeypatch.chdir(tmp_path)
    given = ["--time-limit", "60.0", "--limits", str(limits), *words]
    typed = ["--time-limit", "60.0", "--limits", "limits.yaml", *words]
    batch = mock.Mock()
    batch.return_value.run.return_value = 0
    monkeypatch.setattr("pid_control.programs.batch.Batch", batch)
    monkeypatch.setattr(sys, "argv", ["judge", *typed, "--class", str(tmp_path), *NAMED])
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        command.main()
    folder, finder, options, output, time_limit, roster = batch.call_args[0]
    assert (end.value.code, options, time_limit) == (0, given, 60.0)
    assert (folder, output, roster) == (str(tmp_path), str(tmp_path), {})
    (tmp_path / NAMED[0]).write_text("")
    assert finder.words(str(tmp_path), None)[1:] == NAMED[command is judge :]
