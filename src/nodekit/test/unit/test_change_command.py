"""Errors in the arguments of ``rosrun nodekit change``."""

import sys
from typing import List

import pytest

from nodekit.commands import change as command

NEEDED = "a name and a value are needed for each parameter"


@pytest.mark.parametrize(
    "arguments, hint",
    [
        (["/node/gain", "5"], "; did you mean: rosrun nodekit change /node gain 5"),
        (["lab/node/gain", "5"], "; did you mean: rosrun nodekit change lab/node gain 5"),
        (["/node/word", "a b"], "; did you mean: rosrun nodekit change /node word 'a b'"),
        (["/node", "gain"], ""),
        (["node", "gain"], ""),
        (["/lab/node/", "gain"], ""),
        (["/lab/node"], ""),
        (["/lab/node", "gain", "5", "offset"], ""),
    ],
)
def test_parameter_named_with_its_node_gets_the_corrected_command(
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    arguments: List[str],
    hint: str,
) -> None:
    monkeypatch.setattr(sys, "argv", ["change", *arguments])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"change: error: {NEEDED}{hint}"


def test_value_that_is_not_yaml_is_an_error(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(sys, "argv", ["change", "/node", "gain", "["])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 2
    assert "change: error: while parsing" in capsys.readouterr().err
