"""Node of the simulated AVR, without a build."""

import pathlib
from unittest import mock

import pytest
import rospkg
from std_srvs.srv import Trigger

from serial_link.board.avr_board import BuildError, MemoryUse
from serial_link.board_parameters import AvrParameters
from serial_link.nodes import avr_board
from serial_link.nodes.avr_board import AvrBoardNode

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("serial_link"))


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
            node._folder.mkdir()  # by a compiler that was running
            raise FileNotFoundError("the folder is gone")
        return board

    monkeypatch.setattr(node, "_build", build)
    node._start(0.0)
    assert not abort.called
    assert board.close.called is not fails
    assert not node._folder.exists()


def test_node_ends_if_the_board_cannot_be_built(monkeypatch: "pytest.MonkeyPatch") -> None:
    abort = mock.Mock()
    monkeypatch.setattr(avr_board, "abort", abort)
    node = AvrBoardNode(mock.Mock())
    monkeypatch.setattr(node, "_build", mock.Mock(side_effect=BuildError("avr-g++: no memory")))
    node._start(0.0)
    abort.assert_called_once_with("the board cannot be started: avr-g++: no memory")
    node._end()


def test_node_ends_with_its_simulator(monkeypatch: "pytest.MonkeyPatch") -> None:
    abort, board = mock.Mock(), mock.Mock(is_running=True)
    monkeypatch.setattr(avr_board, "abort", abort)
    around = mock.Mock()
    node = AvrBoardNode(around)
    around.create_timer.assert_called_once_with(1.0, node._start, steady=True)
    around.create_service.assert_called_once_with("~reset", Trigger, node._reset)
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
    headers, make_builder = mock.Mock(), mock.Mock()
    builder, library = make_builder.return_value, mock.Mock(return_value={"made/it.h": "text"})
    monkeypatch.setattr(avr_board, "build_headers", headers)
    monkeypatch.setattr(avr_board, "AvrBuilder", make_builder)
    monkeypatch.setattr(avr_board, "arduino_library", library)
    node = AvrBoardNode(mock.Mock())
    node._values = AvrParameters(
        link="~/ports/board", sketch="~/blink.ino", packages="std_msgs, geometry_msgs"
    )
    builder.size.return_value = MemoryUse(13200, 1500)
    link, program = str(tmp_path / "ports" / "board"), str(builder.sketch.return_value)
    assert node._build()._command == [str(builder.simulator.return_value), program, link]
    assert (tmp_path / "ports").is_dir()
    headers.assert_called_once_with(["std_msgs", "geometry_msgs"])
    assert (node._folder / "made" / "it.h").read_text() == "text"
    builder.sketch.assert_called_once_with(
        tmp_path / "blink.ino",
        (PACKAGE / "avr" / "library", node._folder / "ros_messages" / "src"),
    )
    builder.size.assert_called_once_with(builder.sketch.return_value)
    builder.simulator.assert_called_once_with(PACKAGE / "avr" / "avr_board.c")
    assert "blink.ino: 13200 of 32256 bytes of flash, 1500 of 2048 of RAM" in caplog.text
    builder.size.return_value = MemoryUse(40000, 1500)
    with pytest.raises(BuildError, match="the sketch needs 40000"):
        node._build()
    folder, is_over = make_builder.call_args[0]
    assert folder == node._folder and not is_over()
    node._end()
    assert is_over()  # so that no further compiler is started


def test_missing_sketch_is_named_with_its_path() -> None:
    node = AvrBoardNode(mock.Mock())
    node._values = AvrParameters(sketch="missing.ino")
    with pytest.raises(BuildError, match=f"^{PACKAGE / 'missing.ino'} is missing: set ~sketch to"):
        node._build()
    node._end()


def test_node_has_its_own_name(monkeypatch: "pytest.MonkeyPatch") -> None:
    run = mock.Mock()
    monkeypatch.setattr(avr_board, "run", run)
    avr_board.main()
    run.assert_called_once_with("avr_board", AvrBoardNode)


@pytest.mark.parametrize("link", ["", "tcp"])
def test_board_without_a_serial_port_is_rejected(link: str) -> None:
    with pytest.raises(ValueError, match="link must be a path: this board has only a serial port"):
        AvrParameters(link=link)
