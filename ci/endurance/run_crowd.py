"""Have twenty subscribers come and go at random, in every way there is."""

import contextlib
import random
import socket
import struct
import threading
import time
from typing import List

from ..benchmark.tcpros import Node
from .checks import Check, at_least
from .control import Control
from .run_stalled import returned, undisturbed
from .surroundings import Soak
from .usage import settled_usage
from .watching import ANSWER, SIGNAL, Watch

RATE = 1000.0
CROWD = 20
#: how long they come and go, s
SECONDS = 60.0
#: how long they do so before anything is measured, s
FIRST_SECONDS = 20.0
#: longest stay of one of them, s
LONGEST_STAY = 2.0
#: how long everything has to come back to what it was, s
RECOVERY = 15.0


class Visitor:
    """Subscribes for a while, reads or does not, and leaves politely or not.

    :param soak: where
    :param number: which of them
    """

    WAYS = (
        "reads and unsubscribes",
        "reads and is cut off",
        "never reads and unsubscribes",
        "never reads and is cut off",
    )

    def __init__(self, soak: Soak, number: int) -> None:
        self._soak = soak
        self._chance = random.Random(soak.seed + number)
        self.visits = 0

    def come_and_go(self, until: float) -> None:
        """Pay one visit after the other.

        :param until: monotonic time, s
        """
        while time.monotonic() < until:
            way = self._chance.choice(self.WAYS)
            stay = self._chance.uniform(0.0, LONGEST_STAY)
            with self._soak.session.node() as node:
                self._visit(node, way, min(until, time.monotonic() + stay))
                self.visits += 1

    @staticmethod
    def _visit(node: Node, way: str, until: float) -> None:
        connections: List[socket.socket] = []
        gone = threading.Event()

        def receive(connection: socket.socket) -> None:
            connections.append(connection)
            if gone.is_set():
                connection.close()  # it took so long to come about
            with contextlib.suppress(OSError):
                while not way.startswith("never") and connection.recv(65536):
                    pass

        for topic, type_name in (("/signal", SIGNAL), ("/proc_signal", ANSWER)):
            node.subscribe(topic, type_name, receive)
        time.sleep(max(0.0, until - time.monotonic()))
        gone.set()
        if way.endswith("cut off"):
            for connection in list(connections):
                # Closed with a reset, as when a process or its machine dies.
                linger = struct.pack("ii", 1, 0)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
                connection.close()


def run(soak: Soak) -> List[Check]:
    """Let the crowd in, while one subscriber listens all the time."""
    session = soak.session
    process = soak.start("process.py")
    generator = soak.start("signal_generator.py", f"_rate:={RATE:g}")
    session.wait_for("/signal_generator")
    pids = {"signal_generator": generator.pid, "process": process.pid}
    with session.node() as node:
        watches = [Watch(node, "/signal", SIGNAL, RATE), Watch(node, "/proc_signal", ANSWER)]
        # What a first crowd makes a process take from the system, it keeps for the next.
        crowd(soak, 0, FIRST_SECONDS)
        time.sleep(RECOVERY)
        before = {name: settled_usage(pid) for name, pid in pids.items()}
        for watch in watches:
            watch.restart()
        control = Control(session)
        visits = crowd(soak, CROWD, SECONDS)
        time.sleep(RECOVERY)
        after = {name: settled_usage(pid) for name, pid in pids.items()}
        checks = [at_least(f"visits of {CROWD} subscribers", visits, CROWD)]
        checks += undisturbed(watches, control)
    session.stop(generator, process)
    for name in pids:
        checks += returned(name, before[name], after[name])
    return checks


def crowd(soak: Soak, first: int, seconds: float) -> int:
    """Let all visitors come and go for a while.

    :param first: number of the first of them
    :returns: how many visits there were
    """
    visitors = [Visitor(soak, number) for number in range(first, first + CROWD)]
    until = time.monotonic() + seconds
    threads = [
        threading.Thread(target=visitor.come_and_go, args=(until,), daemon=True)
        for visitor in visitors
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sum(visitor.visits for visitor in visitors)
