"""Tests of the errors of judge_signals before it starts a process."""

import pathlib
import sys
from typing import List
from unittest import mock

import pytest

from pid_control.commands import judge_signals, judging_command
from pid_control.programs import batch
from pid_control.programs.package_messages import MessageTypeError
from pid_control.programs.program_command import CommandError
from pid_control.signal_judging.evidence import GENERATOR, PROCESS, CourseworkEvidence
from pid_control.signal_judging.scenarios import SCENARIOS
from pid_control.signal_runner import coursework_bench


@pytest.mark.parametrize(
    "words, says",
    [
        ([], "not judged: package missing; give its name or its folder"),
        (["no_such_package"], "package not found in ROS_PACKAGE_PATH (no_such_package)"),
        (["{folder}"], "{folder}: no package.xml in it: not a ROS package"),
        (["{folder}/x"], "folder not found ({folder}/x)"),
        (["--only", "signals", "x"], "unknown scenario 'signals'; choose from launch, signal"),
        (["--nodes", "a.py", "x"], "'a.py' must be two programs, with a comma in between"),
        (["--nodes", "a.py,", "x"], "'a.py,' must be two programs"),
        (["--limits", "{folder}/wrong.yaml", "x"], "process: gian: not measured there, but rate"),
        (["--class", "{folder}", "--csv", "{folder}/x.csv"], "--csv: not valid with --class"),
        (["--class", "{folder}", "--picture", "{folder}/x.svg"], "--picture: not valid with"),
        (["--roster", "x.csv", "x"], "--roster: only valid with --class"),
        (["--output", "{folder}", "x"], "--output: only valid with --class"),
        (["--class", "nowhere"], "--class: not a folder (nowhere)"),
        (["--class", "{folder}", "--workspace", "w"], "--workspace: not valid with --class"),
        (["--class", "{folder}"], "no package in {folder}"),
        (["--workspace", "{folder}", "x"], "not a built workspace"),
        (["--picture", "x.png", "x"], "'x.png' does not end in .svg"),
        (["--picture", "{folder}/no/x.SVG", "x"], "{folder}/no/x.SVG: No such file"),
        (["--csv", "{folder}/no/x.csv", "x"], "judge_signals: {folder}/no/x.csv: No such file"),
    ],
)
def test_judge_signals_invalid_request_names_the_problem(
    words: List[str],
    says: str,
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    (tmp_path / "wrong.yaml").write_text("process: {gian: 5}\n")
    before = sorted(tmp_path.iterdir())
    arguments = [word.format(folder=tmp_path) for word in words]
    monkeypatch.setattr(sys, "argv", ["judge_signals", *arguments])
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    output, errors = capsys.readouterr()
    assert end.value.code == 125
    assert says.format(folder=tmp_path) in (output + errors).splitlines()[-1]
    assert sorted(tmp_path.iterdir()) == before


def test_judge_signals_help_has_its_scenarios_and_exit_statuses(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(sys, "argv", ["judge_signals", "--help"])
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    text = capsys.readouterr().out
    assert end.value.code == 0 and text.startswith("usage: judge_signals [-h] [--version]")
    assert text.endswith(HELP)
    options = {word for word in text.split() if word.startswith("--")}
    assert {"--nodes", "--signal", "--proc-signal", "--workspace", "--only"} <= options


#: End of the help: what is typed without a description.
HELP = """
scenarios:
  launch      a launch file starts both nodes
  signal      the generator's messages
  process     the process node's output, compared with its input
  restart     the generator stops, and starts again
  parameters  each parameter is changed
  yaml        the numbers of the YAML files are changed, in a copy
  namespace   both nodes run in a namespace

exit status: 0 passed, 1 failed, 125 not judged
"""


def test_judge_signals_class_run_has_its_roster_and_folders(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    (tmp_path / "roster.csv").write_text("g1,Anna\n")
    make = mock.Mock()
    make.return_value.run.return_value = 1
    monkeypatch.setattr(batch, "Batch", make)
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    monkeypatch.chdir(tmp_path)
    words = ["--class", "x", "--roster", "roster.csv", "--output", "out", "--nodes", "a.py,b.py"]
    monkeypatch.setattr(sys, "argv", ["judge_signals", *words, "a.launch", "b:=1"])
    (tmp_path / "x").mkdir()
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    assert end.value.code == 1
    [(folder, finder, options, output, limit, roster)] = [call[0] for call in make.call_args_list]
    assert (folder, output, limit, roster) == ("x", f"{tmp_path}/out", 120.0, {"g1": "Anna"})
    assert options == ["--time-limit", "120.0", "--nodes", "a.py,b.py"]
    assert finder.words("/p", None) == ["/p", "a.launch", "b:=1"]


@pytest.mark.parametrize("error", [CommandError("no node"), MessageTypeError("no node")])
def test_judge_signals_that_cannot_judge_says_why_after_its_notes(
    error: Exception, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    bench = mock.Mock()
    bench.return_value.run.side_effect = error
    bench.return_value.notes = ["launch file: a.launch"]
    monkeypatch.setattr(coursework_bench, "CourseworkBench", bench)
    monkeypatch.setattr(coursework_bench, "find_request", mock.Mock())
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    monkeypatch.setattr(sys, "argv", ["judge_signals", "anna"])
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines == ["judge: anna", "note: launch file: a.launch", "not judged: no node"]
    assert end.value.code == 125
    bench.return_value.close.assert_called_once_with()


def test_judge_signals_runs_the_chosen_scenarios_and_ends_its_bench(
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    bench, find = mock.Mock(), mock.Mock()
    bench.return_value.run.return_value = CourseworkEvidence(), ""
    bench.return_value.notes = ["launch file: a.launch"]
    monkeypatch.setattr(coursework_bench, "CourseworkBench", bench)
    monkeypatch.setattr(coursework_bench, "find_request", find)
    monkeypatch.setattr(judging_command, "exit_on_signals", lambda: None)  # nor pytest's signals
    options = ["--only", "launch", "--nodes", "a.py,b.py", "--proc-signal", "/y", "--real-time"]
    options += ["--workspace", "ws", "--csv", str(tmp_path / "a.csv")]
    options += ["--picture", str(tmp_path / "a.svg"), "--time-limit", "9"]
    monkeypatch.setattr(sys, "argv", ["judge_signals", *options, "anna", "x"])
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    assert end.value.code == 0
    find.assert_called_once_with(["anna", "x"], ["launch"], "ws")
    find.return_value._replace.assert_called_once_with(
        programs=["a.py", "b.py"], real_time=True, time_limit=9.0, given={PROCESS: "/y"}
    )
    bench.return_value.close.assert_called_once_with()
    assert "anna x: passed" in (tmp_path / "a.svg").read_text()
    assert capsys.readouterr().out.splitlines() == [
        "judge: anna",
        "note: launch file: a.launch",
        "scenario  what                              figure  limit",
        "launch    nodes that no launch file starts  0       <= 0",
        "",
        "passed: all 1 figures of 1 scenario",
    ]
    bench.return_value.run.assert_called_once_with(find.return_value._replace.return_value)
    heading, row = (tmp_path / "a.csv").read_text().splitlines()
    assert heading.startswith("package,verdict,flaws,why,launch.missing_nodes,signal.rate,")
    assert row.startswith("anna x,passed,,,0,")
    # All scenarios, by a simulated clock, unless others are chosen.
    bench.return_value.run.return_value = CourseworkEvidence(), "9 s are over"
    monkeypatch.setattr(sys, "argv", ["judge_signals", "--signal", "/x/y", "anna"])
    with pytest.raises(SystemExit) as end:
        judge_signals.main()
    assert find.call_args == mock.call(["anna"], list(SCENARIOS), None)
    assert find.return_value._replace.call_args == mock.call(
        programs=[], real_time=False, time_limit=120.0, given={GENERATOR: "/x/y"}
    )
    assert end.value.code == 125
    assert capsys.readouterr().out.splitlines()[-1] == "not judged: 9 s are over"
