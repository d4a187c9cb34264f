"""Parameters of the simulated board that take effect at run time."""

import math
import time
from types import SimpleNamespace
from typing import Any, List
from unittest import mock

import pytest
from std_srvs.srv import Trigger

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.board_parameters import BoardParameters
from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import encode
from serial_link.negotiation.payloads import PUBLISHER, TIME, decode_topic
from serial_link.nodes import simulated_board
from serial_link.nodes.simulated_board import SimulatedBoardNode


class FakeNode:
    """Node that has the declared parameters and starts nothing."""

    def __init__(self, **values: Any) -> None:
        self.values = values
        self.at_shutdown: List[Any] = []

    def declare_parameters(self, parameters: Any, on_change: Any) -> Any:
        return SimpleNamespace(values=parameters(**self.values))

    def on_shutdown(self, function: Any) -> None:
        self.at_shutdown.append(function)

    def own(self, resource: Any) -> Any:
        return resource

    def ignore(self, *arguments: Any, **options: Any) -> None:
        pass

    create_service = create_timer = ignore


def test_changed_parameters_reach_the_board_its_controls_and_motor() -> None:
    board = SimulatedBoardNode(FakeNode())  # type: ignore[arg-type]
    assert board._board.boot_s == 0.2 and board._board.faults.is_plugged
    new = BoardParameters(
        boot_time=1.5,
        gain=6.0,
        time_constant=0.1,
        max_speed=9.0,
        dead_zone=0.2,
        noise=0.1,
        stalled=True,
        plugged=False,
        button=True,
        potentiometer=0.7,
    )
    board._on_change(new, BoardParameters())
    assert board._board.boot_s == 1.5
    assert board._board.faults == (0.1, True, False)
    assert board._controls.plant == PlantSettings(6.0, 0.1, 9.0, 0.2)
    assert (board._controls.button, board._controls.potentiometer) == (True, 0.7)


def test_board_starts_with_the_present_buffer_size_and_rate() -> None:
    board = SimulatedBoardNode(FakeNode())  # type: ignore[arg-type]
    board._settings.values = BoardParameters(buffer_size=200, rate=20.0)
    begun = time.monotonic()
    device = board._make_device(begun)
    device.receive(begun, encode(PUBLISHER, b""))
    announced = [frame for frame in Decoder().feed(device.output()) if frame.topic_id != TIME]
    assert {decode_topic(frame.payload).buffer_size for frame in announced} == {200}
    for step in range(1, 1001):
        device.loop(begun + 0.001 * step)
    speeds = [frame for frame in Decoder().feed(device.output()) if frame.topic_id == 125]
    assert 19 <= len(speeds) <= 21


def test_board_has_its_parameters_from_the_start() -> None:
    around: Any = FakeNode(
        link="",
        tcp_address="127.0.0.2",
        tcp_port=11500,
        counts_per_turn=400,
        plugged=False,
        button=True,
        wrong_md5="led",
        floods=True,
    )
    board = SimulatedBoardNode(around)
    transport: Any = board._board._transport
    assert transport._address == ("127.0.0.2", 11500)
    assert not board._board.faults.is_plugged and board._controls.button
    assert board._motor.speed_of(400, 1.0) == pytest.approx(2.0 * math.pi)
    device: Any = board._make_device(0.0)
    sums = {info.name: info.md5sum for _, info in device._announcements}
    assert sums["led"] == sums["button"][::-1]
    assert device._sketch._floods
    assert around.at_shutdown == [board._board.close]


def test_parameters_that_a_running_board_does_not_read_are_marked() -> None:
    declared = BoardParameters.declared
    marked = {name for name, each in declared.items() if each.read_once}
    assert marked == {"link", "tcp_address", "tcp_port", "baud", "counts_per_turn"}


def test_board_is_undamaged_and_has_the_motor_of_the_course_by_default() -> None:
    values = BoardParameters()
    assert values.faults == Faults(0.0, False, True)
    assert values.plant == PlantSettings(13.1, 0.04, 13.0, 0.05)
    assert (values.baud, values.buffer_size, values.rate) == (57600, 512, 100.0)
    assert (values.counts_per_turn, values.potentiometer, values.boot_time) == (1320, 0.5, 0.2)
    assert not (values.button or values.floods or values.wrong_md5)
    assert (values.link, values.tcp_port) == ("~/.ros/simulated_board", 11411)


def test_node_has_its_own_name(monkeypatch: "pytest.MonkeyPatch") -> None:
    run = mock.Mock()
    monkeypatch.setattr(simulated_board, "run", run)
    simulated_board.main()
    run.assert_called_once_with("simulated_board", SimulatedBoardNode)


def test_button_of_the_service_resets_the_board(monkeypatch: "pytest.MonkeyPatch") -> None:
    around: Any = FakeNode()
    around.create_service, around.create_timer = mock.Mock(), mock.Mock()
    board = SimulatedBoardNode(around)
    monkeypatch.setattr(board._board, "reset", mock.Mock())
    (name, kind, press), _ = around.create_service.call_args
    assert (name, kind, press(None)) == ("~reset", Trigger, (True, "reset"))
    assert board._board.reset.call_count == 1  # type: ignore[attr-defined]
    around.create_timer.assert_called_once_with(1.0, board._start, steady=True)


def test_node_ends_if_the_port_cannot_be_created(monkeypatch: "pytest.MonkeyPatch") -> None:
    abort = mock.Mock()
    monkeypatch.setattr(simulated_board, "abort", abort)
    board = SimulatedBoardNode(FakeNode())  # type: ignore[arg-type]
    monkeypatch.setattr(board._board, "start", mock.Mock(side_effect=OSError("read-only")))
    board._start(0.0)
    abort.assert_called_once_with("the board's port cannot be created: read-only")


def test_board_is_started_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    board = SimulatedBoardNode(FakeNode())  # type: ignore[arg-type]
    start = mock.Mock()
    monkeypatch.setattr(board._board, "start", start)
    for elapsed in (0.0, 1.0):
        board._start(elapsed)
    assert start.call_count == 1


class Bench:
    """Board without a thread, whose transport is a mock."""

    def __init__(self, baud: int = 1000) -> None:
        self.transport = mock.Mock(is_plugged=False)
        self.device = mock.Mock(**{"output.return_value": b"", "next_due.return_value": 0.0})
        self.board = SimulatedBoard(self.transport, baud, lambda now: self.device)
        self.turns = 0

    def run(self, turns: int) -> None:
        """Run its loop this many times."""

        def count(data: bytes) -> None:
            self.turns += 1
            if self.turns == turns:
                self.board._is_over.set()

        self.transport.write.side_effect = count
        self.board._run()


def test_bytes_in_transit_are_lost_when_the_cable_is_plugged_in() -> None:
    bench = Bench()
    for line in (bench.board._in, bench.board._out):
        line.put(1.0, b"old")
    bench.board._move_cable(1.0, True)
    assert (bench.board._in.waiting, bench.board._out.waiting) == (0, 0)
    bench.board._move_cable(1.1, True)  # the host does not listen yet
    assert bench.transport.plug.call_count == 1
    bench.board._move_cable(1.3, True)
    assert bench.transport.plug.call_count == 2 and not bench.transport.unplug.called
    bench.transport.is_plugged, bench.board._device = True, bench.device
    bench.board._move_cable(1.4, False)
    assert bench.transport.unplug.call_count == 1
    assert bench.board.device is bench.device  # the sketch keeps running


def test_reset_cuts_a_message_off_and_drops_the_rest() -> None:
    bench = Bench()
    bench.board._device = mock.Mock()
    for line in (bench.board._in, bench.board._out):
        line.put(1.0, b"message")
    bench.board._restart(1.035)
    bench.transport.write.assert_called_once_with(b"mes")
    assert (bench.board._in.waiting, bench.board._out.waiting) == (0, 0)
    assert bench.board.device is None and bench.board._starts_at == 1.035 + bench.board.boot_s


def test_sketch_does_not_run_while_it_hangs_or_its_transmit_buffer_is_full() -> None:
    bench = Bench()
    bench.board._out.put(1.0, bytes(64))
    assert bench.board._is_free()
    bench.board._out.put(1.0, bytes(1))
    assert not bench.board._is_free()
    bench.board._out.clear()
    bench.board.faults = Faults(stalls=True)
    assert not bench.board._is_free()
    bench.board.close()
    assert bench.transport.unplug.called


def test_bytes_that_arrive_while_the_board_boots_are_lost() -> None:
    bench = Bench(baud=0)
    bench.board._starts_at = math.inf
    bench.transport.read.return_value = b"early"
    bench.run(1)
    assert bench.transport.read.called and bench.board._in.waiting == 0


def test_bytes_beyond_the_receive_buffer_of_a_sketch_that_hangs_are_not_read() -> None:
    bench = Bench(baud=0)
    bench.board.faults = Faults(stalls=True)
    bench.transport.read.return_value = bytes(64)
    bench.run(3)
    assert bench.transport.read.call_count == 1 and not bench.device.receive.called


def test_noise_damages_both_directions() -> None:
    bench, data = Bench(baud=0), bytes(range(100))
    bench.board.faults = Faults(noise=1.0)
    bench.transport.read.return_value = bench.device.output.return_value = data
    bench.run(1)
    for call in (bench.device.receive.call_args[0][1], bench.transport.write.call_args[0][0]):
        assert call and call != data
