"""Serial port: its bytes, its loss, and the messages when it cannot be opened."""

import errno
import fcntl
import grp
import os
import pathlib
import subprocess
import sys
import tempfile
import termios
from types import SimpleNamespace
from typing import Iterator, Tuple
from unittest import mock

import pytest

from nodekit.testing.waiting import wait_until
from serial_link.board.transports import PtyTransport
from serial_link.hardware import serial_port
from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.serial_port import SerialPort

#: Opens a port as a user without rights, and prints why it cannot.
AS_NOBODY = """
import os, sys
from serial_link.hardware.ports import PortUnavailable
from serial_link.hardware.serial_port import SerialPort
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
try:
    SerialPort(sys.argv[1], 57600).open(0.0)
except PortUnavailable as error:
    print(error)
"""
#: ioctl that returns whether a terminal is exclusive; termios does not define it.
_TIOCGEXCL = 0x80045440
#: Opens a port, and waits.
OPEN = """
import sys
from serial_link.hardware.serial_port import SerialPort
port = SerialPort(sys.argv[1], 57600)
port.open(0.0)
print('open', flush=True)
sys.stdin.read()
"""
#: Opens a port without a lock, as a terminal program may, and waits.
HOLD = """
import sys
port = open(sys.argv[1], 'rb+', buffering=0)
print('open', flush=True)
sys.stdin.read()
"""


@pytest.fixture
def plugged(tmp_path: pathlib.Path) -> Iterator[Tuple[PtyTransport, SerialPort]]:
    """Return the two ends of a cable."""
    end = PtyTransport(str(tmp_path / "by-id" / "board"))
    end.plug()
    port = SerialPort(str(tmp_path / "by-id" / "board"), 115200)
    yield end, port
    port.release()
    end.unplug()


def test_all_bytes_go_both_ways(plugged: Tuple[PtyTransport, SerialPort]) -> None:
    end, port = plugged
    assert port.open(0.0)
    every = bytes(range(256))
    port.write(every)
    assert end.read() == every
    end.write(every)
    assert port.read(5.0) == every
    assert port.read(0.0) == b""


def test_bytes_before_open_are_not_echoed(
    plugged: Tuple[PtyTransport, SerialPort],
) -> None:
    end, port = plugged
    end.write(b"no host reads")
    assert end.read() == b""
    assert port.open(0.0) and port.read(0.0) == b""


def test_unplugged_cable_is_reported_and_link_finds_new_number(
    plugged: Tuple[PtyTransport, SerialPort],
) -> None:
    end, port = plugged
    port.open(0.0)
    end.unplug()
    with pytest.raises(PortLost, match="by-id/board is gone"):
        port.read(5.0)
    port.close()
    with pytest.raises(PortLost, match="is closed"):
        port.read(0.0)
    with pytest.raises(PortLost, match="is closed"):
        port.write(b"")
    with pytest.raises(PortUnavailable, match="does not exist: is the board plugged in"):
        port.open(0.0)
    end.plug()
    assert port.open(0.0)
    end.write(b"back")
    assert port.read(5.0) == b"back"


def test_second_program_learns_who_has_the_port(
    plugged: Tuple[PtyTransport, SerialPort],
) -> None:
    _, port = plugged
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, port.name],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        universal_newlines=True,
    )
    assert holder.stdout is not None and holder.stdout.readline() == "open\n"
    with pytest.raises(PortUnavailable, match=rf"in use by process {holder.pid} \(.*python"):
        port.open(0.0)
    holder.communicate("")
    assert port.open(0.0)


@pytest.mark.parametrize("is_pseudo", [True, False])
def test_it_has_the_port_for_itself(
    plugged: Tuple[PtyTransport, SerialPort], is_pseudo: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    _, port = plugged
    if not is_pseudo:
        monkeypatch.setattr(serial_port, "_PSEUDO", "/elsewhere/")
    earlier = os.open(port.name, os.O_RDWR | os.O_NOCTTY)  # by this process: no other program
    port.open(0.0)
    with pytest.raises(BlockingIOError):
        fcntl.flock(earlier, fcntl.LOCK_EX | fcntl.LOCK_NB)
    # Programs that ignore locks cannot open it either, unless run by the superuser.
    assert (fcntl.ioctl(earlier, _TIOCGEXCL, bytes(4)) == bytes(4)) is is_pseudo
    with pytest.raises(PortUnavailable, match="in use by a program of another user"):
        SerialPort(port.name, 57600).open(0.0)
    port.close()
    assert fcntl.ioctl(earlier, _TIOCGEXCL, bytes(4)) == bytes(4)
    os.close(earlier)


def test_port_of_simulated_board_is_free_after_node_was_killed() -> None:
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        os.chmod(folder, 0o755)
        end = PtyTransport(os.path.join(folder, "board"))
        end.plug()
        name = os.path.join(folder, "board")
        os.chmod(name, 0o666)
        killed = subprocess.Popen(
            [sys.executable, "-c", OPEN, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert killed.stdout is not None and killed.stdout.readline() == b"open\n"
        killed.kill()
        killed.communicate()
        words = subprocess.run(
            [sys.executable, "-c", AS_NOBODY, name], stdout=subprocess.PIPE, check=True
        ).stdout.decode()
        end.unplug()
    assert words == ""


def test_without_permission_the_sentence_names_the_group() -> None:
    # Unlike pytest's folder, and that of ci/test, /tmp is open to everybody.
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        os.chmod(folder, 0o755)
        place = pathlib.Path(folder) / "ttyUSB0"
        place.touch(0)
        words = subprocess.run(
            [sys.executable, "-c", AS_NOBODY, str(place)], stdout=subprocess.PIPE, check=True
        ).stdout.decode()
    assert "permission denied: users of the group" in words
    if os.getuid() == 0:
        assert "users of the group dialout" in words  # not root, whose group the file has
    assert "sudo usermod -aG" in words and "$USER" in words


def test_invalid_port_is_reported(tmp_path: pathlib.Path) -> None:
    place = tmp_path / "file"
    place.touch()
    with pytest.raises(PortUnavailable, match="file cannot be opened: "):
        SerialPort(str(place), 57600).open(0.0)


def test_group_that_may_open_the_port_is_named(monkeypatch: "pytest.MonkeyPatch") -> None:
    status = SimpleNamespace(st_uid=0, st_gid=20)
    monkeypatch.setattr(os, "stat", lambda path: status)
    names = {0: "root", 20: "uucp"}
    monkeypatch.setattr(grp, "getgrgid", lambda number: SimpleNamespace(gr_name=names[number]))
    words = SerialPort("/dev/ttyUSB0", 57600)._why(PermissionError(errno.EACCES, "denied"))
    assert "users of the group uucp may open it: sudo usermod -aG uucp $USER" in words
    monkeypatch.setattr(grp, "getgrgid", mock.Mock(side_effect=KeyError))  # without a name
    words = SerialPort("/dev/ttyUSB0", 57600)._why(PermissionError(errno.EPERM, "denied"))
    assert "permission denied: users of the group dialout may open it" in words


def test_home_folder_may_be_abbreviated(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setenv("HOME", "/home/student")
    assert SerialPort("~/.ros/board", 57600).name == "/home/student/.ros/board"


def test_read_waits_for_its_timeout(
    plugged: Tuple[PtyTransport, SerialPort], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    _, port = plugged
    port.open(0.0)
    poll = mock.Mock(**{"poll.return_value": []})
    monkeypatch.setattr(port, "_poll", poll)
    assert port.read(0.25) == b""
    poll.poll.assert_called_once_with(250.0)  # [ms]


def test_end_of_file_is_a_loss(
    plugged: Tuple[PtyTransport, SerialPort], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    end, port = plugged
    port.open(0.0)
    end.write(b"x")
    monkeypatch.setattr(os, "read", lambda file, count: b"")
    with pytest.raises(PortLost, match="is gone: end of file"):
        port.read(5.0)
    monkeypatch.undo()


def test_bytes_that_another_program_takes_first_are_no_loss(
    plugged: Tuple[PtyTransport, SerialPort], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    end, port = plugged
    port.open(0.0)
    end.write(b"x")
    with monkeypatch.context() as changed:
        changed.setattr(os, "read", mock.Mock(side_effect=BlockingIOError))
        assert port.read(5.0) == b""
    assert port.read(5.0) == b"x"


def test_rest_of_a_message_that_the_system_accepts_in_part_follows(
    plugged: Tuple[PtyTransport, SerialPort], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    end, port = plugged
    port.open(0.0)
    write, sizes = os.write, iter([3])
    monkeypatch.setattr(os, "write", lambda file, data: write(file, data[: next(sizes, None)]))
    assert port.write_now(b"message")
    received = bytearray()

    def has_all() -> bool:
        received.extend(end.read())
        return received == b"message"

    wait_until(has_all, lambda: f"{received!r}")


def test_stuck_board_blocks_writer_only_briefly(
    plugged: Tuple[PtyTransport, SerialPort],
) -> None:
    _, port = plugged
    port.open(0.0)
    stuck = []

    def is_stuck() -> bool:
        try:
            port.write(bytes(1000))
        except OSError as error:
            stuck.append(str(error))
        return bool(stuck)

    wait_until(is_stuck, lambda: "it takes everything")
    assert "has accepted no bytes for 0.5 s" in stuck[0]


def test_write_now_does_not_block_while_the_buffer_is_full(
    plugged: Tuple[PtyTransport, SerialPort],
) -> None:
    end, port = plugged
    with pytest.raises(PortLost, match="is closed"):
        port.write_now(b"x")
    port.open(0.0)
    assert port.write_now(b"all") and end.read() == b"all"
    with pytest.raises(PortStuck, match="has accepted no bytes for 0.5 s"):
        while port.write_now(bytes(1000)):  # accepts the last ones in part
            pass
    assert not all(port.write_now(b"x") for _ in range(10**5))
    end.unplug()
    with pytest.raises(PortLost, match="is gone"):
        port.write_now(b"x")


@pytest.mark.parametrize("is_native", [False, True])
def test_native_usb_port_has_no_baud_rate_once_it_is_open(
    plugged: Tuple[PtyTransport, SerialPort], is_native: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(serial_port, "has_line", lambda name: not is_native)
    _, port = plugged
    assert port.baud == 115200
    port.open(0.0)
    assert port.baud == (0 if is_native else 115200)
    port.close()
    monkeypatch.setattr(serial_port, "has_line", lambda name: True)
    port.open(0.0)  # another board has the name now
    assert port.baud == 115200
    terminal = os.open(port.name, os.O_RDWR | os.O_NOCTTY)
    assert termios.tcgetattr(terminal)[5] == termios.B115200
    os.close(terminal)
