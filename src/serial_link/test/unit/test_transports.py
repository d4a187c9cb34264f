"""The board's end of the cable."""

import os
import pathlib
import time

import pytest

from serial_link.board.transports import PtyTransport
from serial_link.board.simulation import SimulatedBoard
from serial_link.device.rosserial_device import Device


def test_each_time_that_it_is_plugged_in_there_is_a_terminal_behind_the_link(
    tmp_path: pathlib.Path,
) -> None:
    link = tmp_path / "by-id" / "board"
    end = PtyTransport(str(link))
    files = os.listdir("/proc/self/fd")
    for _ in range(2):
        assert not end.is_plugged and os.listdir("/proc/self/fd") == files
        end.plug()
        assert end.is_plugged and os.path.realpath(link).startswith("/dev/pts/")
        assert end._fd is not None and not os.get_blocking(end._fd)
        end.unplug()
        assert not link.is_symlink()


def test_board_closed_before_start_leaves_no_link(tmp_path: pathlib.Path) -> None:
    """Ctrl-C immediately after the node's start."""

    def never(_now: float) -> Device:
        raise AssertionError("it runs")

    board = SimulatedBoard(PtyTransport(str(tmp_path / "board")), 115200, never, boot_s=0.0)
    board.close()
    board.start()
    assert not (tmp_path / "board").is_symlink()


def test_a_link_that_a_killed_board_has_left_is_replaced(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    link.symlink_to("/dev/pts/none")
    end = PtyTransport(str(link))
    end.plug()
    assert link.exists()
    end.unplug()


def test_foreign_link_is_kept(tmp_path: pathlib.Path) -> None:
    other, late = PtyTransport(str(tmp_path / "board")), PtyTransport(str(tmp_path / "board"))
    other.plug()
    held = os.readlink(tmp_path / "board")
    files = os.listdir("/proc/self/fd")
    with pytest.raises(OSError, match="the port exists already: .* if so, remove it: '.*/board'"):
        late.plug()
    assert os.listdir("/proc/self/fd") == files
    late.unplug()
    assert not late.is_plugged and os.readlink(tmp_path / "board") == held
    other.unplug()
    (tmp_path / "board").write_text("a file")
    with pytest.raises(OSError, match="board"):
        late.plug()
    assert (tmp_path / "board").read_text() == "a file"


def test_a_link_of_the_user_is_in_the_users_folder(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    end = PtyTransport("~/.ros/board")
    end.plug()
    assert (tmp_path / ".ros" / "board").is_symlink()
    end.unplug()


def test_no_exception_without_other_end(tmp_path: pathlib.Path) -> None:
    end = PtyTransport(str(tmp_path / "board"))
    end.write(b"lost")
    assert end.read() == b""
    end.plug()
    for _ in range(20):  # more than the system keeps
        end.write(bytes(1000))
    assert end.read() == b""
    end.wait(0.0)
    end.unplug()
    end.unplug()


def test_waiting_ends_as_soon_as_something_has_arrived(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "board"
    end = PtyTransport(str(link))
    end.plug()
    host = os.open(str(link), os.O_RDWR | os.O_NOCTTY)
    os.write(host, b"x")
    begun = time.monotonic()
    end.wait(5.0)
    assert time.monotonic() - begun < 4.0 and end.read() == b"x"
    begun = time.monotonic()
    end.wait(0.05)
    assert time.monotonic() - begun >= 0.05
    os.close(host)
    end.unplug()


def test_wait_at_a_port_that_is_not_open_lasts_for_its_timeout(
    tmp_path: pathlib.Path,
) -> None:
    end = PtyTransport(str(tmp_path / "board"))
    end.plug()
    begun = time.monotonic()
    end.wait(0.05)
    assert time.monotonic() - begun >= 0.05
    end.unplug()


def test_link_that_cannot_be_marked_is_not_left_behind(tmp_path: pathlib.Path) -> None:
    (tmp_path / "board.board").mkdir()  # in the way of the mark
    end = PtyTransport(str(tmp_path / "board"))
    with pytest.raises(OSError, match=r"board\.board"):
        end.plug()
    assert not end.is_plugged and not (tmp_path / "board").is_symlink()
