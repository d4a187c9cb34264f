#!/usr/bin/env python3
"""A generator or a process node without ROS: the same calls of the kernel, and nothing else.

Usage: floor.py generator RATE OUT | floor.py process IN OUT

IN and OUT are descriptors of connected sockets. It runs until it is ended.
"""

import socket
import struct
import sys
import threading
import time

#: as long as a signal_msg and a Float32 on the wire
SAMPLE = struct.pack("<Iffdf", 20, 2.0, 6.28, 0.0, 0.0)
ANSWER = struct.pack("<If", 4, 0.0)


def generate(rate: float, out: socket.socket) -> None:
    """Send a sample at each moment of a rate in Hz, waiting as nodekit's timers do."""
    never = threading.Lock()
    never.acquire()
    due = time.monotonic()
    while True:
        due += 1.0 / rate
        never.acquire(timeout=max(0.0, due - time.monotonic()))
        out.send(SAMPLE)


def answer(samples: socket.socket, out: socket.socket) -> None:
    """Send an answer for all that has arrived."""
    while samples.recv(65536):
        out.send(ANSWER)


def main() -> None:
    """Run as the one or the other."""
    with open("/proc/self/timerslack_ns", "w") as slack:  # as nodekit's nodes: woken on time
        slack.write("1")
    role, first, second = sys.argv[1:]
    out = socket.socket(fileno=int(second))
    if role == "generator":
        generate(float(first), out)
    else:
        answer(socket.socket(fileno=int(first)), out)


if __name__ == "__main__":
    main()
