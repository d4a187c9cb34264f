"""Node of the simulated AVR, without a build."""

import pathlib
from unittest import mock

import pytest

from serial_link.board.avr_board import BuildError, MemoryUse
from serial_link.board_parameters import AvrParameters
from serial_link.nodes import avr_board
from serial_link.nodes.avr_board import AvrBoardNode


@pytest.mark.parametrize("fails", [True, False])
def test_end_during_the_build_is_no_failure_and_leaves_nothing(
    fails: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    abort, board = mock.Mock(), mock.Mock()
    monkeypatch.setattr(avr_board, "abort", abort)
    node = AvrBoardNode(mock.Mock())

    def build() -> mock.Mock:
        node._end()  # as at Ctrl-C, in another thread
        if fails:
            raise FileNotFoundError("the folder is gone")
        return board

    monkeypatch.setattr(node, "_build", build)
    node._start(0.0)
    assert not abort.called
    assert board.close.called is not fails
    assert not node._folder.exists()


def test_node_ends_with_its_simulator(monkeypatch: "pytest.MonkeyPatch") -> None:
    abort, board = mock.Mock(), mock.Mock(is_running=True)
    monkeypatch.setattr(avr_board, "abort", abort)
    node = AvrBoardNode(mock.Mock())
    assert node._reset(None) == (False, "the board is not built yet")
    monkeypatch.setattr(node, "_build", lambda: board)
    for elapsed in (0.0, 1.0):
        node._start(elapsed)
    assert board.start.call_count == 1 and not abort.called
    assert node._reset(None)[0] and board.reset.call_count == 1
    board.is_running = False
    node._start(2.0)
    abort.assert_called_once_with("the simulator has ended")
    node._end()


def test_build_uses_the_parameters_and_tells_the_size(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    caplog.set_level("INFO", "rosout")
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "blink.ino").touch()
    headers, builder = mock.Mock(), mock.Mock()
    monkeypatch.setattr(avr_board, "build_headers", headers)
    monkeypatch.setattr(avr_board, "AvrBuilder", lambda *arguments: builder)
    monkeypatch.setattr(avr_board, "arduino_library", mock.Mock(return_value={}))
    node = AvrBoardNode(mock.Mock())
    node._values = AvrParameters(
        link="~/ports/board", sketch="~/blink.ino", packages="std_msgs, geometry_msgs"
    )
    builder.size.return_value = MemoryUse(13200, 1500)
    assert node._build()._link == str(tmp_path / "ports" / "board")
    assert (tmp_path / "ports").is_dir()
    headers.assert_called_once_with(["std_msgs", "geometry_msgs"])
    assert "blink.ino: 13200 of 32256 bytes of flash, 1500 of 2048 of RAM" in caplog.text
    builder.size.return_value = MemoryUse(40000, 1500)
    with pytest.raises(BuildError, match="the sketch needs 40000"):
        node._build()
    node._end()


@pytest.mark.parametrize("link", ["", "tcp"])
def test_board_without_a_serial_port_is_rejected(link: str) -> None:
    with pytest.raises(ValueError, match="link must be a path: this board has only a serial port"):
        AvrParameters(link=link)
