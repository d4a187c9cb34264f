"""Links to the ports of simulated boards, some of them killed."""

import os
import pathlib
import subprocess
import sys

import pytest

from serial_link.board.transports import PtyTransport
from serial_link.hardware.ports import PortUnavailable
from serial_link.hardware.serial_port import SerialPort
from serial_link.port_mark import is_left_behind, remove_link, write_mark

BOARD = """
import sys
from serial_link.board.transports import PtyTransport
PtyTransport(sys.argv[1]).plug()
print(flush=True)
sys.stdin.read()
"""


def leave_link(link: pathlib.Path) -> None:
    """Have a board killed; its link leads to a terminal that this process has made since."""
    with subprocess.Popen(
        [sys.executable, "-c", BOARD, str(link)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as board:
        assert board.stdout is not None and board.stdout.readline()
        assert not is_left_behind(str(link))
        board.kill()


def test_node_opens_no_terminal_of_another_program_behind_a_link_that_was_left(
    tmp_path: pathlib.Path,
) -> None:
    link = tmp_path / "board"
    leave_link(link)
    number = os.readlink(link)
    ends = []
    try:
        while not os.path.exists(number):  # the next program gets the number
            ends += os.openpty()
        assert is_left_behind(str(link))
        with pytest.raises(PortUnavailable, match="its simulated board was killed"):
            SerialPort(str(link), 115200).open(0.0)
        assert not link.is_symlink() and list(tmp_path.iterdir()) == []
    finally:
        for end in ends:
            os.close(end)


def test_next_board_replaces_a_link_that_was_left(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    leave_link(link)
    end = PtyTransport(str(link))
    end.plug()
    port = SerialPort(str(link), 115200)
    assert port.open(0.0)
    port.release()
    end.unplug()
    assert list(tmp_path.iterdir()) == []


def test_link_without_a_mark_or_to_another_place_is_followed(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    link.symlink_to("/dev/null")
    assert not is_left_behind(str(link))
    leave_link(tmp_path / "left")
    (tmp_path / "left.board").rename(tmp_path / "board.board")
    assert not is_left_behind(str(link))  # a mark of a terminal that it does not lead to
    write_mark(str(link))
    assert not is_left_behind(str(link))
    (tmp_path / "board.board").write_text("nonsense")
    assert not is_left_behind(str(link))
    remove_link(str(link))
    assert not link.is_symlink()
