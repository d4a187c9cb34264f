"""A sketch on a simulated AVR that returns commands, under resets, cable pulls and noise."""

import collections
import pathlib
import random
import struct
import sys
import time
from typing import Any, DefaultDict, Dict, List, Optional, Sequence, Tuple

from diagnostic_msgs.msg import DiagnosticArray
from serial_link.board.avr_board import AvrBoard, AvrBuilder
from serial_link.commands.make_headers import build_headers, write
from serial_link.headers.arduino_library import arduino_library

from ..benchmark.peer_programs import WORKSPACE, executable
from ..benchmark.recorder import wait_until
from .checks import Check, at_most, none_of, reported
from .context import Soak
from .usage import Sampler, not_grown

PACKAGE = WORKSPACE / "src" / "serial_link"
SKETCH = PACKAGE / "test" / "sketches" / "echo.ino"
COMMANDER = [sys.executable, str(pathlib.Path(__file__).with_name("commander.py"))]
BAUD = 57600
#: Factor of a number for its check value, as in commander.py.
CHECK = 40503
#: Longest time from the end of a fault until a new command is returned [s].
BACK_WITHIN = 10.0
#: Longest wait for it, and time to warm up [s].
PATIENCE, WARM_UP = 60.0, 60.0
KINDS = ("reset", "cable", "cable and reset", "noise", "reset in noise")
#: Longest time in the bootloader, without cable, and with noise [s].
LONGEST_BOOT, LONGEST_PULL, LONGEST_NOISE = 2.0, 3.0, 6.0
#: Least and largest share of damaged bytes, in either direction.
NOISE = (0.001, 0.05)
#: Most wrong values of 10 000 damaged frames, which have a checksum of 8 bits: about
#: three times what is usual, as a run has few.
WRONG_OF_10000 = 60.0
#: Time after noise in which its values may still arrive [s].
ON_THE_WAY = 0.5
_VALUE = struct.Struct("<I")

#: Time and serialized value of each received message.
Messages = Sequence[Tuple[float, bytes]]


def number_in(message: bytes) -> Optional[int]:
    """Return the number of a command; None if its check value is wrong."""
    (value,) = _VALUE.unpack(message)
    number = value >> 16
    return number if number * CHECK & 0xFFFF == value & 0xFFFF else None


def is_newer(number: Optional[int], other: int) -> bool:
    """Return whether a command was sent after another one; 0 is not a command."""
    return bool(number) and 0 < (number or 0) - other & 0xFFFF < 0x8000


def wrong_values(
    messages: Messages, noisy: Sequence[Tuple[float, float]]
) -> Tuple[List[str], List[str]]:
    """Return the wrong values that arrived without noise, and those with it, each once.

    :param noisy: begin and end of each time with noise [s]
    """
    found: Tuple[Dict[str, None], Dict[str, None]] = ({}, {})
    for moment, message in messages:
        if number_in(message) is None:
            is_noisy = any(begin <= moment <= end for begin, end in noisy)
            found[is_noisy][message[::-1].hex()] = None
    return list(found[0]), list(found[1])


def damaged_frames(message: bytes) -> int:
    """Return the number of damaged frames in a message of ``/diagnostics``."""
    values = DiagnosticArray().deserialize(message).status[0].values
    return sum(
        int(one.value)
        for one in values
        if one.key.startswith("fault: ") and one.key != "fault: garbage bytes"
    )


class Faults:
    """Random faults of a board, and the times with noise.

    :param board: the board
    :param seed: of the random numbers

    :ivar noisy: begin and end of each time with noise [s]
    """

    def __init__(self, board: AvrBoard, seed: int) -> None:
        self._board, self._chance = board, random.Random(seed)
        self.noisy: List[Tuple[float, float]] = []

    def cause(self, kind: str) -> None:
        """Cause a fault; return when it is over."""
        chance, board, began = self._chance, self._board, time.monotonic()
        if "noise" in kind:
            board.set_noise(chance.uniform(*NOISE))
            time.sleep(chance.uniform(0.5, LONGEST_NOISE))
        if "cable" in kind:
            board.unplug()
            time.sleep(chance.uniform(0.0, LONGEST_PULL))
            board.plug()
        if "reset" in kind:
            boot_s = chance.uniform(0.0, LONGEST_BOOT)
            board.reset(boot_s)
            time.sleep(boot_s)
        if "noise" in kind:
            board.set_noise(0.0)
            self.noisy.append((began, time.monotonic() + ON_THE_WAY))

    def choose(self) -> str:
        """Return the kind of the next fault."""
        return self._chance.choice(KINDS)


def start_board(folder: pathlib.Path) -> AvrBoard:
    """Build the sketch, and start it."""
    write(arduino_library(build_headers(["std_msgs"]), "a long run", "1.0.0"), folder)
    builder = AvrBuilder(folder)
    libraries = (PACKAGE / "avr" / "library", folder / "ros_messages" / "src")
    simulator = builder.simulator(PACKAGE / "avr" / "avr_board.c")
    board = AvrBoard(simulator, builder.sketch(SKETCH, libraries), str(folder / "board"))
    board.start()
    return board


def run(soak: Soak) -> List[Check]:
    """Cause one fault after the other for the given time."""
    session = soak.session
    board = start_board(session.directory)
    faults = Faults(board, soak.seed)
    back: DefaultDict[str, List[float]] = collections.defaultdict(list)
    with session.record("/command", "std_msgs/UInt32") as sent, session.record(
        "/heard", "std_msgs/UInt32"
    ) as returned, session.record("/diagnostics", "diagnostic_msgs/DiagnosticArray") as status:
        try:
            port = [f"_port:={session.directory / 'board'}", f"_baud:={BAUD}"]
            node = session.start(executable("serial_link", "serial_node.py", *port))
            session.start(COMMANDER)
            sent.wait()
            returned.wait()

            def cause_until(end: float) -> None:
                while time.monotonic() < end:
                    kind = faults.choose()
                    faults.cause(kind)
                    back[kind].append(_time_to_new_command(sent, returned))

            cause_until(time.monotonic() + min(WARM_UP, 0.2 * soak.seconds))
            with Sampler({"node": node.pid}) as sampler:
                cause_until(time.monotonic() + soak.seconds)
        finally:
            board.close()
    wrong, wrong_in_noise = wrong_values(returned.messages, faults.noisy)
    damaged = damaged_frames(status.messages[-1][1])
    share = 1e4 * len(wrong_in_noise) / max(1, damaged)
    return [
        reported("returned values", str(len(returned.messages))),
        *(
            at_most(f"back after {kind} ({len(times)} times), within", max(times), BACK_WITHIN, "s")
            for kind, times in sorted(back.items())
        ),
        none_of("wrong values without noise", wrong),
        reported("damaged frames from the board", str(damaged)),
        at_most("wrong values of 10 000 damaged frames", round(share, 2), WRONG_OF_10000),
        *not_grown("the node", sampler.samples["node"]),
    ]


def _time_to_new_command(sent: Any, returned: Any) -> float:
    """Wait until a command returns that is sent after this call; return the time [s]."""
    began, first = time.monotonic(), len(returned.messages)
    last = number_in(sent.messages[-1][1]) or 0

    def is_back() -> bool:
        messages = returned.messages[first:]
        return any(is_newer(number_in(message), last) for _, message in messages)

    wait_until(is_back, PATIENCE, "return of a command")
    return round(time.monotonic() - began, 2)
