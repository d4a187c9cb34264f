"""Tests of the arguments of ``rosrun nodekit host``."""

import argparse
from typing import Any, List

import pytest

from nodekit.commands import host
from nodekit.timing.timetable import Timetable

CLASS = "nodekit.timing.timetable:Timetable"


@pytest.mark.parametrize(
    "text, base, namespace",
    [
        (CLASS, "timetable", ""),
        ("clock=" + CLASS, "clock", ""),
        ("robot1/clock=" + CLASS, "clock", "robot1/"),
        ("/clock=" + CLASS, "clock", "/"),
    ],
)
def test_member_has_a_name_a_namespace_and_a_class(text: str, base: str, namespace: str) -> None:
    assert host.member(text) == (base, namespace, Timetable)


@pytest.mark.parametrize(
    "text, problem",
    [
        ("nodekit.timing.timetable", "must be MODULE:CLASS"),
        ("nodekit.timing.nothing:Timetable", "No module named 'nodekit.timing.nothing'"),
        ("nodekit.timing.timetable:Nothing", "has no attribute 'Nothing'"),
        ("nodekit.timing.timetable:math", "math is not a class"),
        ("a-b=" + CLASS, "node name 'a-b'"),
        ("robot1/=" + CLASS, "node name ''"),
        (":Timetable", "node name ''"),
        (".timetable:Timetable", "relative import"),
        ("", "must be MODULE:CLASS"),
    ],
)
def test_invalid_member_is_refused_with_a_message(text: str, problem: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError) as raised:
        host.member(text)
    assert str(raised.value).startswith(f"'{text}': ")
    assert problem in str(raised.value)


@pytest.mark.parametrize(
    "arguments, problem",
    [
        ([], "the following arguments are required: MEMBER"),
        ([CLASS, "nothing"], "argument MEMBER: 'nothing': "),
    ],
)
def test_command_that_makes_no_sense_ends_before_there_is_a_node(
    arguments: List[str], problem: str, monkeypatch: "pytest.MonkeyPatch", capsys: Any
) -> None:
    monkeypatch.setattr("sys.argv", ["host", *arguments, "__name:=robot", "__log:=/dev/null"])
    with pytest.raises(SystemExit) as ended:
        host.main()
    assert ended.value.code == 2
    assert problem in capsys.readouterr().err
