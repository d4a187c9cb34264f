"""Node that runs a sketch on a simulated Arduino Uno, with a motor at its pins."""

import pathlib
import shutil
import tempfile
from typing import Any, Optional

import rospkg
import rospy
from std_srvs.srv import Trigger

from nodekit import Node, abort, run
from serial_link.board.avr_board import AvrBoard, AvrBuilder, BuildError
from serial_link.board_parameters import AvrParameters
from serial_link.commands.make_headers import HeaderError, build_headers, write
from serial_link.headers.arduino_library import arduino_library


class AvrBoardNode:
    """Compiled sketch on an ATmega328P in simavr, whose serial port is behind a link.

    At startup it builds the simulator, and the sketch with headers of the messages of ``~packages``
    and a client of rosserial's protocol. A motor with an encoder is connected to the pins.

    :ROS Services:
        - ``~reset`` (std_srvs/Trigger): presses the reset button

    :ROS Parameters:
        - private: see :class:`.AvrParameters`
    """

    def __init__(self, node: Node) -> None:
        self._values = node.declare_parameters(AvrParameters).values
        self._folder = pathlib.Path(tempfile.mkdtemp(prefix="avr_board"))
        self._board: Optional[AvrBoard] = None
        self._has_started = self._has_ended = False
        node.create_service("~reset", Trigger, self._reset)
        node.create_timer(1.0, self._start, steady=True)
        node.on_shutdown(self._end)

    def _start(self, _elapsed: float) -> None:
        if self._has_started:
            if self._board is not None and not self._board.is_running:
                abort("the simulator has ended")
            return
        self._has_started = True
        try:
            board = self._build()
            board.start()
        except (BuildError, HeaderError, OSError) as error:
            if self._has_ended:  # while the board was built, in the folder that is gone
                self._end()
                return
            abort(f"the board cannot be started: {error}")
            return
        self._board = board
        if self._has_ended:
            self._end()

    def _build(self) -> AvrBoard:
        package = pathlib.Path(rospkg.RosPack().get_path("serial_link"))
        sketch = package / pathlib.Path(self._values.sketch).expanduser()
        if not sketch.exists():
            raise BuildError(
                f"{sketch} is missing: set ~sketch to the path of an .ino file; the default "
                "exists only in the source workspace, not in an installation"
            )
        headers = build_headers(self._values.packages.replace(",", " ").split())
        write(arduino_library(headers, self._values.packages, "1.0.0"), self._folder)
        libraries = (package / "avr" / "library", self._folder / "ros_messages" / "src")
        builder = AvrBuilder(self._folder, lambda: self._has_ended)
        program = builder.sketch(sketch, libraries)
        size = builder.size(program)
        rospy.loginfo(
            "%s: %d of 32256 bytes of flash, %d of 2048 of RAM", sketch.name, size.flash, size.ram
        )
        size.check()
        simulator = builder.simulator(package / "avr" / "avr_board.c")
        link = pathlib.Path(self._values.link).expanduser()
        link.parent.mkdir(parents=True, exist_ok=True)
        return AvrBoard(simulator, program, str(link))

    def _reset(self, _request: Any) -> Any:
        if self._board is None:
            return False, "the board is not built yet"
        self._board.reset()
        return True, "reset"

    def _end(self) -> None:
        self._has_ended = True
        if self._board is not None:
            self._board.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def main() -> None:
    """Run the node until it is shut down."""
    run("avr_board", AvrBoardNode)
