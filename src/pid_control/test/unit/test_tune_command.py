"""Tests of the errors of the command tune."""

import pathlib
import sys
from typing import Any, Callable, Dict, List
from unittest import mock

import pytest
import yaml

from pid_control.commands import tune


@pytest.mark.parametrize(
    "arguments, why",
    [
        (["{bad}"], "bad.yaml: system_param_T is missing"),
        (["{bad}.none.yaml"], "none.yaml: No such file or directory"),
        (["{bad}", "--period", "0"], "'0' must be from 0.0001 to 1000 s"),
        (["{bad}", "--method", "guess"], "invalid choice: 'guess'"),
        (["{bad}", "--least", "1"], "--least must be at most 0"),
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
    monkeypatch.setattr(sys, "argv", ["tune", *words, "--gains", str(tmp_path / "gains.yaml")])
    monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        tune.main()
    assert end.value.code == 2 and why in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["bad.yaml"]


@pytest.fixture
def written_gains(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> "Callable[..., Dict[str, Any]]":
    """Return a function that tunes with some options, and returns the written gains."""

    def tuned(*options: str) -> Dict[str, Any]:
        model, gains = tmp_path / "model.yaml", tmp_path / "gains.yaml"
        model.write_text("{system_param_K: 10.0, system_param_T: 0.2}")
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
    assert judged.call_args[1] == {"least": -0.5, "largest": 0.8}
    assert capsys.readouterr().out.count(":\npassed") == 4


def test_tune_method_without_gains_is_refused(
    capsys: "pytest.CaptureFixture[str]", monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(sys, "argv", ["tune", "model.yaml", "--method", "lambda"])
    monkeypatch.setattr(tune, "exit_on_signals", lambda: None)  # nor pytest's signals
    with pytest.raises(SystemExit) as end:
        tune.main()
    assert end.value.code == 2 and "--method: only valid with --gains" in capsys.readouterr().err
