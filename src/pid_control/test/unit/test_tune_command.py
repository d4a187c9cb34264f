"""Tests of the errors of the command tune."""

import pathlib
import sys
from typing import List

import pytest

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
