"""Processes that have a file open, under any name."""

import contextlib
import os
import pathlib
import subprocess
import sys
from typing import Iterator

import pytest
from serial_link.hardware import port_users
from serial_link.hardware.port_users import find_port_users

HOLD = "import sys; file = open(sys.argv[1]); print(flush=True); sys.stdin.read()"


@contextlib.contextmanager
def holder(path: pathlib.Path, *words: str) -> Iterator[int]:
    """Run a process that has a file open; yield its process id.

    :param words: arguments of Python: the program, and those after the file's name
    """
    program, *more = words or (HOLD,)
    option = [] if program.endswith(".py") else ["-c"]
    with subprocess.Popen(
        [sys.executable, *option, program, str(path), *more],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None and process.stdout.readline()
        yield process.pid
        process.communicate(b"")


def test_a_holder_is_found_whatever_it_calls_the_file(tmp_path: pathlib.Path) -> None:
    board, other, link = (tmp_path / name for name in ("board", "other", "link"))
    board.touch()
    os.link(str(board), str(other))
    link.symlink_to(other)
    with holder(other) as pid:
        for name in (board, other, link):
            (found,) = find_port_users(str(name))
            assert found.pid == pid and str(found).startswith(f"process {pid} (")
    with board.open():  # by this process
        assert find_port_users(str(board)) == []


def test_other_file_of_same_name_does_not_count(tmp_path: pathlib.Path) -> None:
    board = tmp_path / "board"
    board.touch()
    with holder(board):
        board.rename(tmp_path / "before")
        board.touch()
        assert find_port_users(str(board)) == []


MAKE = """
import os, sys
from pathlib import Path
master, terminal = os.openpty()
Path(sys.argv[1]).symlink_to(os.ttyname(terminal))
print(flush=True)
sys.stdin.read()
"""


def test_maker_of_a_pseudo_terminal_that_keeps_it_open_is_no_holder(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    with holder(link, MAKE):
        assert find_port_users(str(link)) == []
        with holder(link) as pid:
            (found,) = find_port_users(str(link))
            assert found.pid == pid


def test_maker_is_that_of_this_terminal(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(port_users, "_content", lambda path: "flags:\t02\ntty-index:\t12\n")
    pid = str(os.getpid())
    assert port_users._has_made(pid, "/dev/pts/12") and not port_users._has_made(pid, "/dev/pts/1")


def test_process_that_ends_meanwhile_has_nothing_open(tmp_path: pathlib.Path) -> None:
    assert not port_users._has_open("999999999", os.stat(str(tmp_path)))


def test_unplugged_port_has_no_user(tmp_path: pathlib.Path) -> None:
    assert find_port_users(str(tmp_path / "board")) == []


def test_long_command_is_shown_without_folders(tmp_path: pathlib.Path) -> None:
    board = tmp_path / "board"
    board.touch()
    script = tmp_path / ("folder" * 15) / "monitor.py"
    script.parent.mkdir()
    script.write_text(HOLD)
    python = pathlib.Path(sys.executable).name
    with holder(board, str(script)):
        assert find_port_users(str(board))[0].command == f"{python} monitor.py board"
    with holder(board, str(script), 80 * "a"):
        told = find_port_users(str(board))[0].command
        assert told.startswith(f"{python} monitor.py board aaa")
        assert told.endswith("aaa...") and len(told) == 80
