"""Tests of the output and exit status of ci/mutants."""

import pathlib
import sys
from typing import Any, List

import pytest

from ci.mutation import run
from ci.mutation.mutants import Mutant, Unfit

ASKED = [Mutant("p/a.py", "loop", name, name, 3, f"`{name}` → `pass`") for name in "ab"]


class Stub:
    """Fake evaluation that kills only the first mutant; may be interrupted then."""

    is_interrupted = False

    def __init__(self, place: pathlib.Path, integration: bool) -> None:
        assert integration

    def killer(self, module: str, text: str) -> str:
        if self.is_interrupted and text == "b":
            raise KeyboardInterrupt
        return "a test" if text == "a" else ""

    def left_out(self) -> List[str]:
        return []

    def close(self) -> None:
        pass


@pytest.fixture(autouse=True)
def stub(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(run, "PLACE", tmp_path)
    monkeypatch.setattr(run, "Evaluation", Stub)
    monkeypatch.setattr(run, "draw", lambda tool, modules, count, seed: ASKED[:count])
    monkeypatch.setattr(run.signal, "signal", lambda *_: None)


def main(monkeypatch: "pytest.MonkeyPatch", *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["run.py", "python", "--wiring", *words])
    return run.main(run.options())


def test_report_and_status(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    assert main(monkeypatch) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "1 of 2 killed: src/p/a.py:3: loop: `a` → `pass`"
    assert lines[1] == "2 of 2 SURVIVED: src/p/a.py:3: loop: `b` → `pass`"
    assert lines[-1].startswith("1 of 2 killed, 50.0 %")


def test_interrupted_run_reports_and_resumes(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(Stub, "is_interrupted", True)
    assert main(monkeypatch) == 130
    assert capsys.readouterr().out.splitlines()[-1].startswith("1 of 1 killed")
    monkeypatch.setattr(Stub, "is_interrupted", False)
    assert main(monkeypatch, "--resume") == 1
    assert capsys.readouterr().out.startswith("1 of 1 SURVIVED")
    assert main(monkeypatch, "--resume") == 1
    assert capsys.readouterr().out.startswith("1 of 1 SURVIVED")


def test_paths_may_follow_options_and_are_drawn_from_without_a_limit(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    asked: List[Any] = []
    monkeypatch.setattr(run, "draw", lambda *words: asked.extend(words) or ASKED)
    monkeypatch.chdir(run.WORKSPACE)
    main(monkeypatch, "--seed", "3", "src/nodekit/src/nodekit/timing/timetable.py")
    assert [path.name for path in asked[1]] == ["timetable.py"] and asked[2:] == [sys.maxsize, 3]
    main(monkeypatch)
    assert asked[6] == 120


def test_unfit_request_is_reported(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    def draw(*_: Any) -> None:
        raise Unfit("it does not work")

    monkeypatch.setattr(run, "draw", draw)
    assert main(monkeypatch) == 125
    assert capsys.readouterr().err == "ci/mutants: it does not work\n"
