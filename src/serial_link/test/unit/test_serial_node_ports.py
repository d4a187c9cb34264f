"""Ports of the serial node, by its parameters."""

from typing import Any, List
from unittest import mock

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from serial_link.hardware.tcp_port import TcpServer
from serial_link.nodes import serial_node
from serial_link.nodes.serial_node import SerialNode
from serial_link.serial_parameters import SerialParameters


def context(**parameters: Any) -> mock.Mock:
    """Return a node with these parameters."""
    around = mock.Mock()
    around.name = "/serial_node"
    around.declare_parameters.return_value.values = SerialParameters(**parameters)
    return around


def test_each_board_has_a_port_at_the_given_address_and_a_refused_one_is_logged(
    monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    given: List[Any] = []

    class Server(TcpServer):
        def __init__(self, *arguments: Any) -> None:
            given.extend(arguments)
            super().__init__(*arguments)

    monkeypatch.setattr(serial_node, "TcpServer", Server)
    around = context(port="tcp", tcp_address="127.0.0.2", tcp_port=11500, tcp_boards="right,left")
    node = SerialNode(around)
    names = [board.link.port_name for board in node._boards]
    assert names == ["tcp 127.0.0.2:11500 right", "tcp 127.0.0.2:11500 left"]
    assert [board.side._space for board in node._boards] == ["right", "left"]
    assert node._boards[1].status("/serial_node").name == "serial_node: left"
    owned = [call[0][0] for call in around.own.call_args_list]
    assert owned == [part for board in node._boards for part in (board.link, board.side)]
    given[-1]("the board at 10.0.0.1 is refused")
    assert "the board at 10.0.0.1 is refused" in caplog.text


def test_serial_port_has_the_given_speed_and_calls_the_present_timeout() -> None:
    around = context(port="/dev/ttyACM0", baud=115200)
    (board,) = SerialNode(around)._boards
    assert (board.link.port_name, board.link.baud) == ("/dev/ttyACM0", 115200)
    assert board.status("/serial_node").name == "serial_node: board"
    around.declare_parameters.return_value.values = SerialParameters(service_timeout=0.5)
    assert board.side._timeout() == 0.5


def test_words_of_the_command_line_are_port_and_number_and_options_are_ignored(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    around = context()
    monkeypatch.setattr(rospy, "myargv", lambda: ["serial_node.py", "--help", "tcp", "11500"])
    names: List[str] = []
    monkeypatch.setattr(serial_node, "run", lambda name, make: (names.append(name), make(around)))
    serial_node.main()
    assert names == ["serial_node"]
    update = around.declare_parameters.return_value.update
    update.assert_called_once_with(port="tcp", tcp_port="11500")


def test_all_boards_are_started_once_reported_and_stopped_at_shutdown(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    around = context()
    node = SerialNode(around)
    around.create_timer.assert_called_once_with(1.0, node._report, steady=True)
    boards = [mock.Mock(), mock.Mock()]
    for name, board in zip("ab", boards):
        board.status.return_value = DiagnosticStatus(name=name)
    monkeypatch.setattr(node, "_boards", boards)
    monkeypatch.setattr(rospy, "get_rostime", lambda: rospy.Time(12, 500000000))
    for elapsed in (0.0, 1.0):
        node._report(elapsed)
    (report,) = around.create_publisher.return_value.publish.call_args[0]
    assert report.header.stamp == rospy.Time(12, 500000000)
    assert [status.name for status in report.status] == ["a", "b"]
    assert serial_node._ros_time() == (12, 500000000)  # for the board
    around.on_shutdown.call_args[0][0]()
    for board in boards:
        counts = [board.link.start, board.side.start, board.link.send_stop]
        assert [function.call_count for function in counts] == [1, 1, 1]
