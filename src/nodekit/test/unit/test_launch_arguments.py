"""Tests of the warning about arguments that roslaunch ignores, by one node."""

import os
import pathlib
import subprocess
import sys
from typing import Any, List

import pytest
import rospkg
from roslaunch.arg_dump import get_args

from nodekit.process.launch_arguments import ignored

SOURCES = pathlib.Path(__file__).resolve().parents[3]
#: Those of the workspace that hand arguments on, and the course's.
FILES = [
    path
    for path in sorted(SOURCES.glob("*/launch/**/*.launch"))
    if path.name == "cw1.launch" or "pass_all_args" in path.read_text(encoding="utf-8")
]

SAID = "roslaunch ignores the argument"

#: A stand-in for roslaunch: starts what it calls rosout, then two nodes, which live until all have
#: said what they have to.
ROSLAUNCH = """
import subprocess, sys
PIPE = subprocess.PIPE
started = [
    subprocess.Popen([sys.executable, "-c", text, "__name:=" + name], stdin=PIPE, stdout=PIPE)
    for name, text in (("rosout", {first!r}), ("one", {node!r}), ("two", {node!r}))
]
for each in started:
    each.stdin.write(b"say\\n")
    each.stdin.flush()
    print(each.stdout.readline().decode(), end="")
for each in started:
    each.stdin.write(b"end\\n")
    each.communicate()
"""
FIRST = "print(input(), flush=True); input()"
NODE = """
import sys
from nodekit.process.launch_arguments import warnings
sys.stdin.readline()
print(sys.argv[-1], warnings(), flush=True)
sys.stdin.readline()
"""


def written(folder: Any, **texts: str) -> str:
    """Write launch files, and return the folder."""
    for name, text in texts.items():
        (folder / f"{name}.launch").write_text(f"<launch>{text}</launch>")
    return str(folder)


def said(folder: str, *arguments: str) -> List[str]:
    return ignored(["one.launch", *arguments], folder)


def test_an_argument_that_is_not_taken(tmp_path: Any) -> None:
    folder = written(tmp_path, one='<arg name="frequency" default="1"/>')
    assert said(folder) == said(folder, "frequency:=2", "__ns:=/lab", "_x:=1") == []
    assert said(folder, "frequenzy:=2", "frequency:=1", "other:=", "__log:=x") == [
        f"{SAID} frequenzy: it is not declared in one.launch; did you mean frequency?",
        f"{SAID} other: it is not declared in one.launch",
    ]


def test_several_files_have_arguments_together(tmp_path: Any) -> None:
    folder = written(tmp_path, one='<arg name="rate"/>', two='<arg name="gain"/>')
    words = ["one.launch", "two.launch", "rate:=1", "gain:=2", "gaim:=3"]
    told = f"{SAID} gaim: it is not declared in one.launch, two.launch; did you mean gain?"
    assert ignored(words, folder) == [told]


def test_arguments_passed_to_included_files(tmp_path: Any) -> None:
    """Test that an included file gets arguments that are passed by name, or all; no others."""
    two = '<arg name="rate" default="1"/><include file="$(dirname)/one.launch" pass_all_args="1"/>'
    include = '<include file="$(dirname)/two.launch" {}><arg name="gain" value="1"/></include>'
    folder = written(tmp_path, one=include.format(""), two=two)
    assert len(said(folder, "rate:=2", "gain:=3")) == 2
    written(tmp_path, one="<group>" + include.format('pass_all_args="true"') + "</group>")
    assert said(folder, "rate:=2") == []
    assert len(said(folder, "gain:=2")) == 1


def test_file_of_a_package_with_options_in_any_position() -> None:
    told = f"{SAID} signal_frequenzy: it is not declared in cw1.launch; did you mean "
    for options, after in (([], []), (["-p", "11311"], []), (["--wait"], ["--screen"])):
        words = [*options, "basic_comms", "cw1.launch", *after]
        (line,) = ignored([*words, "signal_frequenzy:=1", "signal_rate:=5"], "/")
        assert line == told + "signal_frequency?"
    assert ignored(["-", "a:=1"], "/") == []


def test_a_file_that_is_not_there_or_no_xml(tmp_path: Any) -> None:
    with pytest.raises(OSError):
        said(str(tmp_path), "a:=1")
    folder = written(
        tmp_path, one='<include file="$(find no_such_one)/a.launch" pass_all_args="true"/>'
    )
    with pytest.raises(rospkg.ResourceNotFound):
        said(folder, "a:=1")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_arguments_of_roslaunch_are_accepted(path: pathlib.Path) -> None:
    words = [str(path)]
    arguments = [f"{name}:=1" for name in get_args([str(path)])]
    assert ignored([*words, *arguments], "/") == []
    assert len(ignored([*words, *arguments, "no_such_argument:=1"], "/")) == 1


def test_only_one_node_warns(tmp_path: Any) -> None:
    folder = written(tmp_path, one='<arg name="rate"/>')
    (tmp_path / "roslaunch").write_text(ROSLAUNCH.format(first=FIRST, node=NODE))
    command = [sys.executable, os.path.join(folder, "roslaunch"), "one.launch"]

    def lines(argument: str) -> List[str]:
        done = subprocess.run(
            [*command, argument], cwd=folder, check=True, stdout=subprocess.PIPE, text=True
        )
        return done.stdout.splitlines()

    told = f"{SAID} ratte: it is not declared in one.launch; did you mean rate?"
    assert lines("ratte:=1") == ["say", f"__name:=one ['{told}']", "__name:=two []"]
    (tmp_path / "one.launch").unlink()
    assert lines("ratte:=1") == ["say", "__name:=one []", "__name:=two []"]
