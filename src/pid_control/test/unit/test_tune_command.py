"""Tests of the errors of the command tune."""

import pathlib
import sys
from typing import Any, Callable, Dict, List
from unittest import mock

import pytest
import yaml

from pid_control.commands import identify, tune
from pid_control.tuning.rules import METHODS


@pytest.mark.parametrize(
    "arguments, why",
    [
        (["{bad}"], "{bad}: system_param_T is missing"),
        (["{bad}.none.yaml"], "{bad}.none.yaml: No such file or directory"),
        (["{bad}/.."], "{bad}/..: Not a directory"),
        (["{bad}", "--period", "0"], "error: argument --period: '0' must be from 0.0001 to 1000 s"),
        (
            ["{bad}", "--wanted", "1001"],
            "error: argument --wanted: '1001' must be from 0.0001 to 1000 s",
        ),
        (
            ["{bad}", "--method", "guess"],
            "error: argument --method: invalid choice: 'guess' (choose from 'simc', 'lambda', "
            "'ziegler-nichols-pi', 'ziegler-nichols-pid')",
        ),
        (["{bad}", "--least", "1"], "--least must be at most 0, and --largest above it"),
        (["{bad}", "--largest", "0"], "--least must be at most 0, and --largest above it"),
        (
            ["{bad}", "--picture", "p.gif"],
            "error: argument --picture: 'p.gif' does not end in .svg",
        ),
        (
            ["{bad}", "--gains", "g.txt"],
            "error: argument --gains: 'g.txt' does not end in .yaml or .yml",
        ),
    ],
)
def test_tune_invalid_arguments_name_the_problem(
    arguments: List[str],
    why: str,
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("system_param_K: 10.0\n")
    words = [word.format(bad=bad) for word in arguments]
    gains = ["--gains", str(tmp_path / "gains.yaml")]
    monkeypatch.setattr(sys, "argv", ["tune", *gains, *words, "__ns:=/space"])
    monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        tune.main()
    output, errors = capsys.readouterr()
    assert (end.value.code, output) == (2, "")
    assert errors.splitlines()[-1] == f"tune: {why.format(bad=bad)}"
    assert "Traceback" not in errors
    assert [path.name for path in tmp_path.iterdir()] == ["bad.yaml"]


MODEL = "{system_param_K: 10.0, system_param_T: 0.2}"
TABLE = """\
                            kp  ki, 1/s     kd, s  rise, s  overshoot  settled, s
simc                    0.1818   0.9091         0     0.11      1.4 %         0.2
lambda                 0.07843   0.3922         0     0.45      0.0 %        0.87
ziegler-nichols-pi      0.3273    1.785         0     0.09      2.5 %        0.63
ziegler-nichols-pid     0.4364    3.967     0.012     0.09      8.0 %        0.47
"""
GAINS = """\
# simc (Skogestad 2003), for {model}.
mode: PI
kp: 0.1818
ki: 0.9091  # 1/s
kd: 0.0  # s
filter_time: 0.0  # s
output_min: -1.0
output_max: 1.0
"""
PID_GAINS = """\
# ziegler-nichols-pid (Ziegler and Nichols 1942), for {model}.
mode: PID
kp: 0.4
ki: 3.333  # 1/s
kd: 0.012  # s
filter_time: 0.003  # s
output_min: -0.5
output_max: 2.0
"""


def test_tune_prints_each_method_and_writes_the_gains_of_one(
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    model, gains = tmp_path / "model.yaml", tmp_path / "gains.yaml"
    model.write_text(MODEL.replace("}", ", system_dead_time: 0.05, system_max_speed: 8.0}"))
    signals = mock.Mock()
    monkeypatch.setattr(tune, "exit_on_signals", signals)
    command = ["tune", str(model)]
    monkeypatch.setattr(sys, "argv", command)
    tune.main()
    assert capsys.readouterr() == (TABLE, "")
    assert [path.name for path in tmp_path.iterdir()] == ["model.yaml"]
    command += ["--gains", str(gains)]
    tune.main()
    assert gains.read_text() == GAINS.format(model=model)
    command += ["--method", "ziegler-nichols-pid", "--least", "-0.5", "--largest", "2"]
    command += ["--period", "0.02"]
    tune.main()
    assert gains.read_text() == PID_GAINS.format(model=model)
    assert signals.call_count == 3


@pytest.mark.parametrize(
    "error, status, why",
    [
        (UnicodeDecodeError("utf-8", b"\xe9", 0, 1, "invalid"), 2, "{model}: 'utf-8' codec can't"),
        (OSError(28, "No space left on device", "g.yaml"), 2, "g.yaml: No space left on device"),
        (KeyboardInterrupt(), 130, ""),
    ],
)
def test_tune_that_fails_has_its_status(
    error: BaseException,
    status: int,
    why: str,
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    model = tmp_path / "model.yaml"
    model.write_text(MODEL)
    monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
    monkeypatch.setattr(tune, "gains_of", mock.Mock(side_effect=error))
    monkeypatch.setattr(sys, "argv", ["tune", str(model)])
    with pytest.raises(SystemExit) as end:
        tune.main()
    said = f"tune: {why.format(model=model)}" if why else ""
    errors = capsys.readouterr().err
    assert end.value.code == status and errors.startswith(said) and bool(errors) is bool(why)


@pytest.mark.parametrize("command", [tune, identify])
def test_version_is_that_of_the_package(
    command: Any, capsys: "pytest.CaptureFixture[str]", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr("nodekit.package_version.package_version", "1.0 of {}".format)
    name = command.__name__.rpartition(".")[2]
    with pytest.raises(SystemExit) as end:
        command._parser().parse_args(["--version"])
    said = f"{name} of pid_control 1.0 of pid_control\n"
    assert (end.value.code, capsys.readouterr().out) == (0, said)


@pytest.fixture
def written_gains(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> "Callable[..., Dict[str, Any]]":
    """Return a function that tunes with some options, and returns the written gains."""

    def tuned(*options: str) -> Dict[str, Any]:
        model, gains = tmp_path / "model.yaml", tmp_path / "gains.yaml"
        model.write_text(MODEL)
        monkeypatch.setattr(sys, "argv", ["tune", str(model), "--gains", str(gains), *options])
        monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
        tune.main()
        return dict(yaml.safe_load(gains.read_text()))

    return tuned


def test_tune_writes_gains_with_the_limits_of_the_output(
    tmp_path: pathlib.Path, written_gains: "Callable[..., Dict[str, Any]]"
) -> None:
    picture = tmp_path / "p.svg"
    found = written_gains("--least", "-0.5", "--largest", "0.8", "--picture", str(picture))
    assert (found["output_min"], found["output_max"]) == (-0.5, 0.8)
    assert picture.read_text().count("<polyline") == 9  # the set point, and two of each method


def test_tune_uses_the_period_and_the_wanted_time_constant(
    written_gains: "Callable[..., Dict[str, Any]]",
) -> None:
    found = written_gains("--period", "0.1", "--wanted", "0.35")
    # The mean delay of the period is 0.05 s.
    assert found["kp"] == pytest.approx(0.2 / (10.0 * (0.35 + 0.05)))
    found = written_gains("--period", "0.1")  # by SIMC, whose time constant is that delay
    assert found["kp"] == pytest.approx(0.2 / (10.0 * (0.05 + 0.05)))


def test_tune_writes_the_gains_of_the_method_and_judges_all_with_the_limits(
    written_gains: "Callable[..., Dict[str, Any]]",
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    judged = mock.Mock(side_effect=lambda several, **_: [(one, "passed") for one in several])
    monkeypatch.setattr("pid_control.runner.gains_judgement.judge_gains", judged)
    limits = ["--least", "-0.5", "--largest", "0.8"]
    found = written_gains("--method", "lambda", "--judge", *limits)
    # The integral time of lambda is T, of SIMC four times the period at most.
    assert found["kp"] / found["ki"] == pytest.approx(0.2)
    (several,), named = judged.call_args
    assert [one.method for one in several] == list(METHODS)
    assert named == {"least": -0.5, "largest": 0.8}
    said = "".join(f"\n{method}:\npassed\n" for method in METHODS)
    assert capsys.readouterr().out.endswith(said)


def test_tune_method_without_gains_is_refused(
    capsys: "pytest.CaptureFixture[str]", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(sys, "argv", ["tune", "model.yaml", "--method", "lambda"])
    monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        tune.main()
    assert end.value.code == 2
    assert capsys.readouterr().err == "tune: --method: only valid with --gains\n"
