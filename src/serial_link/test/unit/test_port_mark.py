"""Links to the ports of simulated boards, some of them killed."""

import os
import pathlib
import subprocess
import sys
from typing import Iterator
from unittest import mock

import pytest

from serial_link.board.transports import PtyTransport
from serial_link.hardware.ports import PortUnavailable
from serial_link.hardware.serial_port import SerialPort
from serial_link import port_mark
from serial_link.port_mark import is_left_behind, remove_link, remove_own_link, write_mark

BOARD = """
import sys
from serial_link.board.transports import PtyTransport
PtyTransport(sys.argv[1]).plug()
print(flush=True)
sys.stdin.read()
"""


def leave_link(link: pathlib.Path) -> None:
    """Simulate a killed board, whose link leads to a terminal of this process."""
    with subprocess.Popen(
        [sys.executable, "-c", BOARD, str(link)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as board:
        assert board.stdout is not None and board.stdout.readline()
        assert not is_left_behind(str(link))
        board.kill()


def test_leftover_link_to_foreign_terminal_is_not_opened(
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


def test_link_without_matching_mark_is_followed(tmp_path: pathlib.Path) -> None:
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


@pytest.fixture
def left(tmp_path: pathlib.Path) -> Iterator[pathlib.Path]:
    """Return the link of a killed board, for a test to corrupt its mark."""
    leave_link(tmp_path / "board")
    files = os.listdir("/proc/self/fd")
    assert is_left_behind(str(tmp_path / "board"))
    assert os.listdir("/proc/self/fd") == files
    yield tmp_path / "board"


def mark_of(link: pathlib.Path) -> pathlib.Path:
    return link.with_name(link.name + ".board")


def test_mark_with_too_long_numbers_is_invalid(left: pathlib.Path) -> None:
    _, *others = mark_of(left).read_text().split(" ")
    for pid in ("9" * 5000, "9" * 10, "0"):
        mark_of(left).write_text(" ".join([pid, *others]))
        assert not is_left_behind(str(left))


def test_fifo_or_link_is_invalid_mark(left: pathlib.Path) -> None:
    mark_of(left).rename(left.with_name("elsewhere"))
    mark_of(left).symlink_to(left.with_name("elsewhere"))
    assert not is_left_behind(str(left))
    mark_of(left).unlink()
    os.mkfifo(str(mark_of(left)))
    assert not is_left_behind(str(left))


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give a file to another user")
def test_mark_of_another_user_is_invalid(left: pathlib.Path) -> None:
    os.chown(str(mark_of(left)), 12345, -1)
    assert not is_left_behind(str(left))


def test_mark_overwrites_no_file_that_a_link_in_its_place_leads_to(tmp_path: pathlib.Path) -> None:
    link, target = tmp_path / "board", tmp_path / "target"
    target.write_text("a user's")
    link.symlink_to("/dev/null")
    mark_of(link).symlink_to(target)
    write_mark(str(link))
    assert target.read_text() == "a user's" and not mark_of(link).is_symlink()
    assert mark_of(link).stat().st_mode & 0o444 == 0o444  # the nodes of other users read it


def test_process_that_the_system_hides_has_not_ended(
    left: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    words = mark_of(left).read_text().split(" ")
    mark_of(left).write_text(" ".join([words[0], words[1], "pid:[1]", words[3]]))
    assert not is_left_behind(str(left))  # its number is of another namespace
    remove_link(str(left))
    left.symlink_to("/dev/null")
    write_mark(str(left))
    refused = mock.Mock(side_effect=PermissionError)  # as with hidepid
    monkeypatch.setattr(port_mark, "open", refused, raising=False)
    assert not is_left_behind(str(left))


def test_process_of_another_user_has_not_ended(
    left: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    write_mark(str(left))  # of this process
    monkeypatch.setattr(os, "kill", mock.Mock(side_effect=PermissionError))
    assert not is_left_behind(str(left))


def test_process_whose_number_another_one_has_now_has_ended(left: pathlib.Path) -> None:
    _, began, *others = mark_of(left).read_text().split(" ")
    mark_of(left).write_text(" ".join([str(os.getpid()), began, *others]))
    assert is_left_behind(str(left))


def test_name_of_a_program_may_have_brackets(monkeypatch: "pytest.MonkeyPatch") -> None:
    words = ["7", "(an", "odd)", "name)", *map(str, range(30))]
    monkeypatch.setattr(port_mark, "_words", lambda path: words)
    assert port_mark._began(7) == "19"


def test_only_own_link_is_removed(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    link.symlink_to("/dev/pts/none")
    write_mark(str(link))
    remove_own_link(str(link), "/dev/null")
    assert link.is_symlink() and mark_of(link).exists()
    link.unlink()
    remove_own_link(str(link), "/dev/pts/none")
    assert not mark_of(link).exists()
    link.write_text("a user's")
    remove_own_link(str(link), "")
    assert link.exists()
