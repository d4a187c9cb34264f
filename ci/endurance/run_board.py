"""A board behind a bad cable that is reset and unplugged, for long."""

import random
import socket
import statistics
import threading
import time
from typing import List, Optional

from serial_link.board.ends import PtyEnd
from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.device.device import Device
from serial_link.framing.frames import encode

from ..benchmark.observers import wait_until
from ..benchmark.plain_board import NODE, OUT, UINT64, PlainSketch, Sender, number_of, numbered
from ..benchmark.tcpros import split_messages
from .checks import Check, at_least, at_most, none_of, reported
from .surroundings import Soak
from .usage import Sampler, added, growth

TIMES = 50
BAUD, RATE = 115200, 100.0
#: Share of the bytes that are damaged, lost or doubled, either way.
NOISE = 0.01
#: The id of the only topic of the board.
TOPIC_ID = 125
#: Longest time until messages come again, s: on this cable four of ten answers of the board to the
#: question for its topics arrive whole.
BACK_WITHIN = 5.0
#: Longest time that the cable is out, s.
LONGEST_OUT = 1.0
#: Share of the messages that do not come whole that an 8-bit sum lets through at most: it sees what
#: damages one byte, and of all other damage all but one in 256.
UNSEEN = 0.004


class NumberingSketch(PlainSketch):
    """Publishes numbers, and goes on counting after a reset.

    :param truth: what the board has ever sent
    """

    def __init__(self, truth: "Truth") -> None:
        super().__init__()
        self._truth, self._next_at = truth, 0.0

    def loop(self, device: Device, now: float) -> None:
        """Publish the next number when it is due."""
        if now >= self._next_at and device.is_configured:
            self._next_at = max(self._next_at + 1.0 / RATE, now)
            device.publish(OUT, numbered(self._truth.sent))
            self._truth.sent += 1

    def next_due(self, now: float) -> float:
        """Return when the next number is due, s."""
        return max(self._next_at, now + 0.001)


class TappedEnd(PtyEnd):
    """The end of the cable, with all that has ever left it.

    :ivar tap: those bytes, damaged as they are
    """

    def __init__(self, link: str) -> None:
        super().__init__(link)
        self.tap = bytearray()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self.tap += data
        super().write(data)


class Truth:
    """What was sent, and what was heard of it.

    :ivar sent: how many messages the board has sent
    :ivar heard: how many have come whole
    :ivar wrong: those that have not, as they came
    """

    def __init__(self) -> None:
        self.sent = self.heard = 0
        self.wrong: List[bytes] = []
        self.heard_at = 0.0

    def listen(self, connection: socket.socket) -> None:
        """Hear what the link publishes."""
        threading.Thread(target=self._read, args=(connection,), daemon=True).start()

    def _read(self, connection: socket.socket) -> None:
        rest = b""
        while True:
            try:
                data = connection.recv(65536)
            except OSError:
                return
            if not data:
                return
            messages, rest = split_messages(rest + data)
            for payload in messages:
                self.heard_at = time.monotonic()
                number = number_of(payload)
                if number is None or number >= self.sent:
                    self.wrong.append(payload)
                else:
                    self.heard += 1


def run(soak: Soak) -> List[Check]:
    """Reset and unplug the board at random moments, and compare what comes with what was sent."""
    chance, truth = random.Random(soak.seed), Truth()
    port = str(soak.session.directory / "board")
    end = TappedEnd(port)
    sketches: List[NumberingSketch] = []

    def make_device(_now: float) -> Device:
        sketches.append(NumberingSketch(truth))
        return Device(sketches[-1])

    board = SimulatedBoard(end, BAUD, make_device, seed=soak.seed)
    board.faults = Faults(NOISE)
    board.start()
    link = soak.session.start([str(NODE), f"_port:={port}", f"_baud:={BAUD}"])
    times = soak.times or TIMES
    resets, returns = [], []
    with soak.session.node() as node, Sampler({"link": link.pid}) as sampler:
        node.subscribe(OUT, UINT64.name, truth.listen)
        sender = Sender(node)
        sender.wait()
        driving = _Driver(sender)
        wait_until(lambda: truth.heard > 0, 30.0, "message of the board")
        pause = soak.seconds / (2 * times)
        for turn in range(2 * times):
            time.sleep(pause * chance.uniform(0.5, 1.0))
            if turn % 2:
                board.reset()
                resets.append(_time_until_back(truth, time.monotonic() + board.boot_s))
            else:
                board.faults = Faults(NOISE, is_plugged=False)
                time.sleep(chance.uniform(0.1, LONGEST_OUT))
                board.faults = Faults(NOISE)
                returns.append(_time_until_back(truth, time.monotonic()))
        driving.stop()
    board.close()
    to_board = [payload for sketch in sketches for _, payload in sketch.heard]
    ended = link.poll()
    return [
        none_of("the link ended", [] if ended is None else [f"with {ended}"]),
        *_back("reset", resets),
        *_back("unplugged", returns),
        *_messages(truth, end, to_board),
        *_flat(sampler),
    ]


class _Driver:
    """Publishes numbers to the board, until it is stopped."""

    def __init__(self, sender: Sender) -> None:
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(sender,), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Publish no more."""
        self._is_over.set()
        self._thread.join()

    def _run(self, sender: Sender) -> None:
        number = 0
        while not self._is_over.wait(1.0 / RATE):
            sender.send(numbered(number))
            number += 1


def _time_until_back(truth: Truth, since: float) -> Optional[float]:
    """Wait for the next message after a moment; return how long after it that came, s."""
    try:
        wait_until(lambda: truth.heard_at > since, BACK_WITHIN + 30.0, "message of the board")
    except TimeoutError:
        return None
    return truth.heard_at - since


def _back(what: str, times: List[Optional[float]]) -> List[Check]:
    found = sorted(one for one in times if one is not None)
    lost = [f"number {place}" for place, one in enumerate(times) if one is None]
    return [
        reported(f"board {what}", f"{len(times)} times"),
        none_of(f"never back after it was {what}", lost),
        reported("back, median", f"{statistics.median(found):.2f} s" if found else "never"),
        at_most("the longest", round(found[-1], 2) if found else 0.0, BACK_WITHIN, "s"),
    ]


def _messages(truth: Truth, end: TappedEnd, to_board: List[bytes]) -> List[Check]:
    not_whole = max(1, truth.sent - truth.heard)
    unsound = [payload.hex() for payload in truth.wrong if encode(TOPIC_ID, payload) not in end.tap]
    wrong_there = sum(number_of(payload) is None for payload in to_board)
    return [
        reported("messages that the board has sent", str(truth.sent)),
        at_least("of them heard", round(100.0 * truth.heard / max(1, truth.sent), 1), 50.0, "%"),
        none_of("delivered though no frame with good sums was on the line", unsound),
        reported("delivered wrong, as an 8-bit sum held", str(len(truth.wrong))),
        at_most(
            "these of all that have not come whole", round(len(truth.wrong) / not_whole, 5), UNSEEN
        ),
        at_least("messages that the board has heard", len(to_board), 100),
        reported("of them wrong, as an 8-bit sum held", str(wrong_there)),
    ]


def _flat(sampler: Sampler) -> List[Check]:
    samples = sampler.samples["link"]
    grown = 100.0 * growth([one.memory for one in samples])
    return [
        at_most("growth of the link's memory", round(grown, 2), 2.0, "%"),
        at_most("its new threads", added([one.threads for one in samples]), 0),
        at_most("its new descriptors", added([one.descriptors for one in samples]), 0),
    ]
