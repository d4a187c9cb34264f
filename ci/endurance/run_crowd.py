"""Let twenty subscribers come and go at random, in every way there is."""

import contextlib
import random
import socket
import struct
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import List

from ..benchmark.tcpros import Node
from .checks import Check, at_least
from .context import Soak, signal_pair
from .watching import ANSWER, SIGNAL

CROWD = 20
#: How long they come and go, before the measurement and during it [s].
FIRST_SECONDS, SECONDS = 20.0, 60.0
#: Longest stay of a subscriber, and time for everything to recover [s].
LONGEST_STAY, RECOVERY = 2.0, 15.0
WAYS = (
    "reads and unsubscribes",
    "reads and is cut off",
    "never reads and unsubscribes",
    "never reads and is cut off",
)


def run(soak: Soak) -> List[Check]:
    """Let the crowd in, while one good subscriber listens all the time."""
    with signal_pair(soak) as pair:
        # What the first crowd makes a process take from the system is kept for the next one.
        visit_at_once(soak, 0, FIRST_SECONDS)
        time.sleep(RECOVERY)
        pair.begin()
        visits = visit_at_once(soak, CROWD, SECONDS)
        time.sleep(RECOVERY)
        return [at_least(f"visits of {CROWD} subscribers", visits, CROWD), *pair.end()]


def visit_at_once(soak: Soak, first: int, seconds: float) -> int:
    """Let all subscribers come and go for a while.

    :param first: number of the first of them
    :returns: the number of visits
    """
    until = time.monotonic() + seconds
    with ThreadPoolExecutor(CROWD) as pool:
        visitors = range(first, first + CROWD)
        return sum(pool.map(lambda number: visit_again(soak, number, until), visitors))


def visit_again(soak: Soak, number: int, until: float) -> int:
    """Subscribe again and again until a moment, as one subscriber; return how often."""
    chance, visits = random.Random(soak.seed + number), 0
    while time.monotonic() < until:
        way, stay = chance.choice(WAYS), chance.uniform(0.0, LONGEST_STAY)
        with soak.session.node() as node:
            visit(node, way, min(until, time.monotonic() + stay))
        visits += 1
    return visits


def visit(node: Node, way: str, until: float) -> None:
    """Subscribe in one of the WAYS until a moment."""
    connections: List[socket.socket] = []
    gone = threading.Event()

    def receive(connection: socket.socket) -> None:
        connections.append(connection)
        if way.startswith("never"):
            gone.wait()
        while not gone.is_set() and connection.recv(65536):
            pass

    for topic, type_name in (("/signal", SIGNAL), ("/proc_signal", ANSWER)):
        node.subscribe(topic, type_name, receive)
    time.sleep(max(0.0, until - time.monotonic()))
    if way.endswith("cut off"):
        for connection in list(connections):
            # Closed with a reset, as when a process or its machine dies.
            with contextlib.suppress(OSError):
                linger = struct.pack("ii", 1, 0)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    else:
        node.close()
    gone.set()
