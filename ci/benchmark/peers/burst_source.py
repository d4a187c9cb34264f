#!/usr/bin/env python3
"""A source of signal_msg at any rate. Usage: ... MASTER_URI TOPIC MD5SUM

Reads lines "RATE SECONDS" from standard input; sends that many messages a second for that long,
each by itself as client libraries do; answers "COUNT LATE", LATE being how far it fell behind at
worst, in s, because a subscriber did not take them.
"""

import math
import socket
import struct
import sys
import time
from typing import List, Tuple

from ci.benchmark.observers import wait_until
from ci.benchmark.tcpros import Node, TopicType

DEFINITION = "float32 amplitude\nfloat32 frequency\nfloat64 time_x\nfloat32 signal_y\n"
FRAME = struct.Struct("<Iffdf")
AMPLITUDE, FREQUENCY = 2.0, 2.0 * math.pi
TICK = 0.0002  # s
#: A source that is so far behind is of no use any more, s.
HOPELESS = 0.15
#: Longest wait for a subscriber, to come or to take one message, s.
PATIENCE = 30


def frame(number: int, rate: float) -> bytes:
    """Return a sample of a sine as it goes on the wire."""
    time_x = number / rate
    value = AMPLITUDE * math.sin(FREQUENCY * time_x)
    return FRAME.pack(FRAME.size - 4, AMPLITUDE, FREQUENCY, time_x, value)


def send(connections: List[socket.socket], rate: float, seconds: float) -> Tuple[int, float]:
    """Send at a rate to all subscribers.

    :returns: how many messages, and how far behind at worst, s
    :raises OSError: a subscriber has gone, or takes nothing for too long
    """
    for connection in connections:
        # By the kernel: Python's own time-out would cost another system call for each message.
        limit = struct.pack("ll", PATIENCE, 0)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, limit)
    total = int(rate * seconds)
    sent, latest = 0, 0.0
    start = time.monotonic()
    while sent < total and latest < HOPELESS:
        due = min(total, int((time.monotonic() - start) * rate) + 1)
        for number in range(sent, due):
            data = frame(number, rate)
            for connection in connections:
                connection.sendall(data)
        sent = due
        now = time.monotonic()
        latest = max(latest, now - start - sent / rate)
        time.sleep(max(0.0, TICK - (now - start) % TICK))
    return sent, latest


def main() -> None:
    """Obey standard input until it ends."""
    master_uri, topic, md5sum = sys.argv[1:]
    connections: List[socket.socket] = []
    node = Node("/burst_source", master_uri)
    node.advertise(
        topic, TopicType("basic_comms/signal_msg", md5sum, DEFINITION), connections.append
    )
    for line in sys.stdin:
        rate, seconds = map(float, line.split())
        wait_until(lambda: bool(connections), PATIENCE, "subscriber")
        print("%d %.6f" % send(connections, rate, seconds), flush=True)
    node.close()


if __name__ == "__main__":
    main()
