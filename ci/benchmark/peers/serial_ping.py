"""Send pings to a board, and write the time of each answer; usage: serial_ping.py FILE RATE COUNT.

The file is a JSON list of pairs: the answer's number, and its time since the ping [s].
"""

import json
import os
import sys
import time
from typing import Dict, List, Tuple

from nodekit import Node, run
from std_msgs.msg import UInt32

FILE, RATE, COUNT = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
#: Longest wait for the last answers [s].
PATIENCE_S = 5.0


class Ping:
    """Publishes ``ping``, at first slowly until an answer arrives, and subscribes to ``pong``."""

    def __init__(self, node: Node) -> None:
        self._sent: Dict[int, float] = {}
        self._answers: List[Tuple[int, float]] = []
        self._is_answered = False
        self._publisher = node.create_publisher("ping", UInt32, queue_size=1000)
        node.create_subscription("pong", UInt32, self._receive)
        node.create_timer(10.0, self._call_board)
        node.create_timer(RATE, self._ping)

    def _call_board(self, _time: float) -> None:
        if not self._is_answered:
            self._publisher.publish(UInt32(COUNT))

    def _ping(self, _time: float) -> None:
        number, now = len(self._sent), time.monotonic()
        if number < COUNT and self._is_answered:
            self._sent[number] = now
            self._publisher.publish(UInt32(number))
        elif number == COUNT and (
            len(self._answers) == COUNT or now > self._sent[number - 1] + PATIENCE_S
        ):
            with open(FILE + ".part", "w", encoding="utf-8") as file:
                json.dump(self._answers, file)
            os.rename(FILE + ".part", FILE)
            self._sent[COUNT] = now  # once

    def _receive(self, pong: UInt32) -> None:
        self._is_answered = True
        if pong.data in self._sent:
            self._answers.append((pong.data, time.monotonic() - self._sent[pong.data]))


if __name__ == "__main__":
    run("ping", Ping)
