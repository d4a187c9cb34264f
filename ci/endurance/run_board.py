"""A board behind a bad cable that is reset and unplugged, for long."""

import contextlib
import random
import socket
import statistics
import struct
import time
import zlib
from typing import List, Optional, Tuple

from serial_link.board.ends import PtyEnd
from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.device.device import Declared, Device
from serial_link.framing.frames import encode
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, Values

from ..benchmark.peer_programs import executable
from ..benchmark.recorder import wait_until
from ..benchmark.tcpros import receive_messages
from .checks import Check, at_least, at_most, none_of, reported
from .context import Soak
from .usage import Sampler, not_grown

TIMES = 50
BAUD, RATE = 115200, 100.0
OUT, IN = "/from_board", "/to_board"
TYPE, MD5SUM = "std_msgs/UInt64", "1b2a79973e8bf53d7b53acb71299cb57"
#: Share of the bytes that are damaged, lost or doubled, either way.
NOISE = 0.01
#: The id of the board's only topic.
TOPIC_ID = 125
#: Longest time until messages are back [s]: on this cable four of ten answers of the board to the
#: request for its topics arrive whole.
BACK_WITHIN = 5.0
#: Longest time that the cable is out [s].
LONGEST_OUT = 1.0
#: Share of the damaged messages that an 8-bit sum accepts at most: it detects any damage to one
#: byte, and 255 of 256 other ones.
UNSEEN = 0.004

_VALUE = struct.Struct("<Q")


def numbered(number: int) -> bytes:
    """Return a message with a number of 32 bits and its checksum."""
    return _VALUE.pack(number << 32 | zlib.crc32(struct.pack("<I", number)))


def number_of(payload: bytes) -> Optional[int]:
    """Return the number of a message; None if it is damaged."""
    number = int(_VALUE.unpack(payload)[0]) >> 32
    return number if numbered(number) == payload else None


class Counts:
    """Messages that the board has sent, and those that arrived on either side.

    :ivar sent: messages sent by the board; of these ``heard`` arrived whole, ``wrong`` damaged
    :ivar heard_at: moment of the latest arrival [s]
    :ivar to_board: messages that arrived at the board
    """

    def __init__(self) -> None:
        self.sent = self.heard = 0
        self.wrong: List[bytes] = []
        self.heard_at = 0.0
        self.to_board: List[bytes] = []

    def read(self, connection: socket.socket) -> None:
        """Count what the link publishes."""
        for moment, messages in receive_messages(connection):
            for payload in messages:
                self.heard_at = moment
                number = number_of(payload)
                if number is None or number >= self.sent:
                    self.wrong.append(payload)
                else:
                    self.heard += 1


class NumberingSketch:
    """Sketch that publishes numbers, and continues to count after a reset."""

    topics: Tuple[Declared, ...] = (
        Declared(PUBLISHER, OUT, TYPE, MD5SUM),
        Declared(SUBSCRIBER, IN, TYPE, MD5SUM),
    )

    def __init__(self, counts: Counts) -> None:
        self._counts, self._next_at = counts, 0.0

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        """Keep a message."""
        self._counts.to_board.append(payload)

    def on_parameter(self, device: Device, now: float, values: Values) -> None:
        """Ignore parameters."""

    def loop(self, device: Device, now: float) -> None:
        """Publish the next number when it is due."""
        if now >= self._next_at and device.is_configured:
            self._next_at = max(self._next_at + 1.0 / RATE, now)
            device.publish(OUT, numbered(self._counts.sent))
            self._counts.sent += 1

    def next_due(self, now: float) -> float:
        """Return when the next number is due [s]."""
        return max(self._next_at, now + 0.001)


class TappedEnd(PtyEnd):
    """End of the cable that keeps all bytes sent, damaged as they are."""

    def __init__(self, link: str) -> None:
        super().__init__(link)
        self.tap = bytearray()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self.tap += data
        super().write(data)


def run(soak: Soak) -> List[Check]:
    """Reset and unplug the board at random moments, and compare what arrives with what was sent."""
    chance, counts, session = random.Random(soak.seed), Counts(), soak.session
    port = str(session.directory / "board")
    end = TappedEnd(port)
    board = SimulatedBoard(end, BAUD, lambda _now: Device(NumberingSketch(counts)), seed=soak.seed)
    board.faults = Faults(NOISE)
    board.start()
    link = session.start(
        executable("serial_link", "serial_node.py", f"_port:={port}", f"_baud:={BAUD}")
    )
    (value,) = _VALUE.unpack(numbered(7))
    session.start(["rostopic", "pub", "-r", f"{RATE:g}", IN, TYPE, str(value)])
    times = soak.times or TIMES
    resets, returns = [], []
    with contextlib.ExitStack() as stack:
        stack.enter_context(session.node()).subscribe(OUT, TYPE, counts.read)
        wait_until(lambda: counts.heard and counts.to_board, 30.0, "messages of the board")
        sampler = stack.enter_context(Sampler({"the link": link.pid}))
        pause = soak.seconds / (2 * times)
        for _ in range(times):
            time.sleep(pause * chance.uniform(0.5, 1.0))
            board.faults = Faults(NOISE, is_plugged=False)
            time.sleep(chance.uniform(0.1, LONGEST_OUT))
            board.faults = Faults(NOISE)
            returns.append(_time_until_back(counts, time.monotonic()))
            time.sleep(pause * chance.uniform(0.5, 1.0))
            board.reset()
            resets.append(_time_until_back(counts, time.monotonic() + board.boot_s))
    board.close()
    ended = link.poll()
    return [
        none_of("the link ended", [] if ended is None else [f"with {ended}"]),
        *_check_returns("reset", resets),
        *_check_returns("unplugged", returns),
        *_check_messages(counts, end),
        *not_grown("the link", sampler.samples["the link"], limit=2.0),
    ]


def _time_until_back(counts: Counts, since: float) -> Optional[float]:
    """Return the time from a moment to the next message [s]; None after the last one."""
    try:
        wait_until(lambda: counts.heard_at > since, BACK_WITHIN + 30.0, "message of the board")
    except TimeoutError:
        return None
    return counts.heard_at - since


def _check_returns(what: str, times: List[Optional[float]]) -> List[Check]:
    found = [one for one in times if one is not None] or [0.0]
    lost = [f"number {place}" for place, one in enumerate(times) if one is None]
    return [
        reported(f"board {what}", f"{len(times)} times"),
        none_of(f"never back after it was {what}", lost),
        reported("back, median", f"{statistics.median(found):.2f} s"),
        at_most("the longest", round(max(found), 2), BACK_WITHIN, "s"),
    ]


def _check_messages(counts: Counts, end: TappedEnd) -> List[Check]:
    damaged = max(1, counts.sent - counts.heard)
    unsound = [one.hex() for one in counts.wrong if encode(TOPIC_ID, one) not in end.tap]
    wrong_there = sum(number_of(payload) is None for payload in counts.to_board)
    heard = round(100.0 * counts.heard / max(1, counts.sent), 1)
    unseen = round(len(counts.wrong) / damaged, 5)
    return [
        reported("messages that the board has sent", str(counts.sent)),
        at_least("of them heard", heard, 50.0, "%"),
        none_of("delivered though no frame with good sums was on the line", unsound),
        reported("delivered wrong, as an 8-bit sum held", str(len(counts.wrong))),
        at_most("these of all that have not arrived whole", unseen, UNSEEN),
        at_least("messages that the board has heard", len(counts.to_board), 100),
        reported("of them wrong, as an 8-bit sum held", str(wrong_there)),
    ]
