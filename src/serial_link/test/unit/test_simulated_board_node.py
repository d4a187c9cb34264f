"""Parameters of the simulated board that take effect at run time."""

import time
from types import SimpleNamespace
from typing import Any

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.board_parameters import BoardParameters
from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import encode
from serial_link.negotiation.payloads import PUBLISHER, TIME, decode_topic
from serial_link.nodes.simulated_board import SimulatedBoardNode


class FakeNode:
    """Node that has the declared parameters and starts nothing."""

    def declare_parameters(self, parameters: Any, on_change: Any) -> Any:
        return SimpleNamespace(values=parameters())

    def own(self, resource: Any) -> Any:
        return resource

    def ignore(self, *arguments: Any, **options: Any) -> None:
        pass

    create_service = create_timer = on_shutdown = ignore


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
