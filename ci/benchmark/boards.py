"""What the link to a board adds to the bytes' own time, what it carries, and what it costs."""

import statistics
import time
from typing import Callable, Dict, List

from .context import Bench, Figures
from .cost import cpu_share, cpu_time
from .observers import Recorder, wait_until
from .plain_board import FRAME, IN, NODE, OUT, UINT64, PlainBoard, Sender, numbered

ROUND_TRIP, CAPACITY, BUSY, IDLE = "round trip", "90 % of the line", "100 Hz both ways", "idle"
SUBJECTS = [ROUND_TRIP, CAPACITY, BUSY, IDLE]

BAUD = 115200
#: What the line carries, messages a second: ten bits a byte.
MOST = BAUD / 10 / FRAME
SHARE = 0.9
RATE = 100.0
#: What the node is given to settle, and the last messages to arrive, s.
SETTLED, LAST = 1.5, 1.0


class Link:
    """The link, a board at one end and a node of ROS at the other.

    :param board: the board
    :param sender: publishes to it
    :param recorder: hears it
    :param pids: of the link
    """

    def __init__(
        self, board: PlainBoard, sender: Sender, recorder: Recorder, pids: List[int]
    ) -> None:
        self.board, self.sender, self.recorder, self.pids = board, sender, recorder, pids


def measure(bench: Bench, subject: str) -> Figures:
    """Measure one of SUBJECTS."""
    measures: Dict[str, Callable[[Bench, Link], Figures]] = {
        ROUND_TRIP: _round_trip,
        CAPACITY: _capacity,
        BUSY: _busy,
        IDLE: _idle,
    }
    port = str(bench.session.directory / f"board-{time.monotonic_ns()}")
    command = [str(NODE), f"_port:={port}", f"_baud:={BAUD}"]
    with PlainBoard(port) as board, bench.session.node() as node:
        recorder, sender = Recorder(node, OUT, UINT64.name), Sender(node)
        with bench.session.running(command) as pids:
            board.wait_until_asked()
            sender.wait()
            time.sleep(SETTLED)
            board.send(numbered(0))
            recorder.wait()
            return measures[subject](bench, Link(board, sender, recorder, pids))


def _round_trip(bench: Bench, link: Link) -> Figures:
    """Measure from the board to a node, and from a node to the board; both take the host's part."""
    sent: List[float] = []
    heard = link.board.sketch.heard
    for number in range(1, round(bench.seconds(10.0, 2.0) * RATE)):
        time.sleep(1.0 / RATE)
        sent.append(time.monotonic())
        link.board.send(numbered(number))
        link.recorder.wait(number + 1, 5.0)
        sent.append(time.monotonic())
        link.sender.send(numbered(number))
        wait_until(lambda: len(heard) >= number, 5.0, f"message on {IN}")
    # Only now: to look at all messages meanwhile would keep those who hear them from the processor.
    received = [moment for moment, _ in link.recorder.messages()[1:]]
    up = [moment - began for began, moment in zip(sent[::2], received)]
    down = [moment - began for began, (moment, _) in zip(sent[1::2], heard)]
    both = [one + other for one, other in zip(up, down)]
    return {
        "p50_us": 1e6 * statistics.median(both),
        "up_p50_us": 1e6 * statistics.median(up),
        "down_p50_us": 1e6 * statistics.median(down),
    }


def _capacity(bench: Bench, link: Link) -> Figures:
    """Send as much as the line nearly takes, both ways at once."""
    count = round(bench.seconds(10.0, 2.0) * SHARE * MOST)
    received = len(link.recorder.messages())
    _send(link, count, SHARE * MOST)
    time.sleep(LAST)
    return {
        "lost_to_board": float(count - len(link.board.sketch.heard)),
        "lost_from_board": float(count - (len(link.recorder.messages()) - received)),
        "rate": SHARE * MOST,
    }


def _busy(bench: Bench, link: Link) -> Figures:
    began, used = time.monotonic(), cpu_time(link.pids)
    _send(link, round(bench.seconds(10.0, 2.0) * RATE), RATE)
    return {"cpu_percent": 100.0 * (cpu_time(link.pids) - used) / (time.monotonic() - began)}


def _idle(bench: Bench, link: Link) -> Figures:
    return {"cpu_percent": cpu_share(link.pids, bench.seconds(10.0, 3.0))}


def _send(link: Link, count: int, rate: float) -> None:
    """Send numbered messages both ways, each at its time."""
    began = time.monotonic()
    for number in range(1, count + 1):
        time.sleep(max(0.0, began + number / rate - time.monotonic()))
        link.board.send(numbered(number))
        link.sender.send(numbered(number))
