"""Tests of the runner of a user's commands, with commands that hang."""

import pathlib

import pytest

from ci.packages import proof

#: Command that prints when it ignores Ctrl-C.
DEAF = ("sh", "-c", "trap '' INT; echo deaf; exec sleep 60")


@pytest.fixture(autouse=True)
def folder(monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path) -> None:
    monkeypatch.chdir(tmp_path)


def wait_until_deaf(monkeypatch: "pytest.MonkeyPatch") -> None:
    proof.wait_for("it is deaf", lambda: "deaf" in pathlib.Path("proof.log").read_text())
    monkeypatch.setattr(proof, "PATIENCE", 0.1)


def test_command_that_hangs_does_not_succeed(monkeypatch: "pytest.MonkeyPatch") -> None:
    assert proof.succeeds("true")
    assert not proof.succeeds("false")
    monkeypatch.setattr(proof, "PATIENCE", 0.1)
    assert not proof.succeeds("sleep", "60")


def test_failed_command_is_reported() -> None:
    with pytest.raises(SystemExit, match="ended with status -2"):
        with proof.running("sleep", "60"):
            pass


def test_hung_command_is_killed_and_reported(monkeypatch: "pytest.MonkeyPatch") -> None:
    with pytest.raises(SystemExit, match="ended with SIGKILL, 0 s after Ctrl-C: status -9"):
        with proof.running(*DEAF):
            wait_until_deaf(monkeypatch)


def test_error_while_running_is_reported_though_the_command_hangs(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    with pytest.raises(SystemExit, match="not as it should be"):
        with proof.running(*DEAF):
            wait_until_deaf(monkeypatch)
            raise SystemExit("not as it should be")
