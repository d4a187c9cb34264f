"""Node of the simulated AVR, without a build."""

from unittest import mock

import pytest

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


def test_node_ends_with_its_simulator(monkeypatch: "pytest.MonkeyPatch") -> None:
    abort, board = mock.Mock(), mock.Mock(is_running=True)
    monkeypatch.setattr(avr_board, "abort", abort)
    node = AvrBoardNode(mock.Mock())
    monkeypatch.setattr(node, "_build", lambda: board)
    for elapsed in (0.0, 1.0):
        node._start(elapsed)
    assert board.start.call_count == 1 and not abort.called
    board.is_running = False
    node._start(2.0)
    abort.assert_called_once_with("the simulator has ended")
    node._end()


@pytest.mark.parametrize("link", ["", "tcp"])
def test_board_without_a_serial_port_is_rejected(link: str) -> None:
    with pytest.raises(ValueError, match="link must be a path: this board has only a serial port"):
        AvrParameters(link=link)
