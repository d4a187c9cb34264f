"""Parameters of the simulated board that take effect at run time."""

from types import SimpleNamespace
from typing import Any

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.board_parameters import BoardParameters
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
