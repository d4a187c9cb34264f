"""Node that simulates a board with a motor and rosserial's library."""

import time
from typing import Any

from std_srvs.srv import Trigger

from nodekit import Node, abort, run
from serial_link.board.transports import Transport, PtyTransport, TcpTransport
from serial_link.board.simulation import SimulatedBoard
from serial_link.board_parameters import BoardParameters
from serial_link.device.rosserial_device import Device
from serial_link.device.motor import Motor
from serial_link.device.motor_sketch import BoardControls, MotorSketch


class SimulatedBoardNode:
    """Simulated board on a serial port or a TCP connection, which carries its topics.

    The parameters and the service are the actions of a person at the board: button, potentiometer,
    cable, reset, and faults.

    :ROS Services:
        - ``~reset`` (std_srvs/Trigger): presses the reset button

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.BoardParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(BoardParameters, on_change=self._on_change)
        values = self._settings.values
        self._motor = Motor(values.plant, values.counts_per_turn, time.monotonic())
        self._controls = BoardControls(values.plant)
        end: Transport = TcpTransport(values.tcp_address, values.tcp_port)
        if values.link:
            end = PtyTransport(values.link)
        self._board = node.own(SimulatedBoard(end, values.baud, self._make_device))
        self._has_started = False
        node.on_shutdown(self._board.close)  # or the link to its port would remain
        node.create_service("~reset", Trigger, self._reset)
        node.create_timer(1.0, self._start, steady=True)
        self._on_change(values, values)

    def _start(self, _elapsed: float) -> None:
        if not self._has_started:
            self._has_started = True
            try:
                self._board.start()
            except OSError as error:
                abort(f"the board's port cannot be created: {error}")

    def _make_device(self, now: float) -> Device:
        values = self._settings.values
        sketch = MotorSketch(self._motor, self._controls, values.rate, now, values.floods)
        return Device(sketch, values.buffer_size, values.buffer_size, values.wrong_md5)

    def _on_change(self, new: BoardParameters, _old: BoardParameters) -> None:
        self._board.faults = new.faults
        self._board.boot_s = new.boot_time
        self._controls.plant = new.plant
        self._controls.button, self._controls.potentiometer = new.button, new.potentiometer

    def _reset(self, _request: Any) -> Any:
        self._board.reset()
        return True, "reset"


def main() -> None:
    """Run the node until it is shut down."""
    run("simulated_board", SimulatedBoardNode)
