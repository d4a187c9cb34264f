#!/usr/bin/env python3
"""Measure the load of the scope: ``ci/exec src/topic_scope/test/measure_load.py``.

It starts a master, a node that publishes ten topics at 1 kHz, and a scope, and prints the scope's
load with no page, with one and with three. With ``--publish`` it is that node.
"""

import argparse
import math
import os
import pathlib
import subprocess
import sys
import time
from typing import List

TOPICS, RATE = 10, 1000.0
#: Largest delay of the node [s]; longer delays of a busy machine are skipped.
LATE_S = 1.0
BINS, WINDOW = 1200, 10.0


def publish() -> None:
    """Publish sines that are a tenth of a period apart."""
    import rospy
    from std_msgs.msg import Float32

    from nodekit import Publisher

    rospy.init_node("load")
    names = [rospy.resolve_name(f"load{index}") for index in range(TOPICS)]
    publishers = [Publisher(name, Float32) for name in names]
    for publisher in publishers:
        publisher.open()
    start, count = time.monotonic(), 0
    while not rospy.is_shutdown():
        count += 1
        for index, publisher in enumerate(publishers):
            phase = 2 * math.pi * (count / RATE + index / TOPICS)
            publisher.publish(Float32(math.sin(phase)))
        early = start + count / RATE - time.monotonic()
        if early < -LATE_S:  # not caught up: the rate would exceed RATE
            start -= early
        time.sleep(max(0.0, early))


def seconds_of(pid: int) -> float:
    """Return the CPU time of a process [s]."""
    words = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def megabytes_of(pid: int) -> float:
    """Return the memory of a process [MB]."""
    words = pathlib.Path(f"/proc/{pid}/statm").read_text().split()
    return int(words[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def measure(seconds: float) -> None:
    """Start everything, print the table, end everything.

    :param seconds: measuring time of each row
    """
    from browsing.scope_process import ScopeProcess
    from wire.client import Client

    from nodekit.testing.processes import free_port
    from nodekit.testing.waiting import wait_until

    port = str(free_port())
    os.environ["ROS_MASTER_URI"] = "http://localhost:" + port
    master = subprocess.Popen(["rosmaster", "--core", "-p", port], stdout=subprocess.DEVNULL)
    load = subprocess.Popen([sys.executable, __file__, "--publish"])
    fields = [f"/load{index}/data" for index in range(TOPICS)]
    scope = ScopeProcess(*fields)
    clients: List[Client] = []
    try:
        scope.wait_until_served()
        print("pages  % of a core  frames/s  messages/s  memory, MB")
        for count in (0, 1, 3):
            while len(clients) < count:
                clients.append(Client(scope.url))
                clients[-1].send("view", window=WINDOW, width=BINS, end=None)
            for client in clients:
                wait_until(lambda: client.values(fields[-1]), lambda: "no samples")
            time.sleep(WINDOW)
            for client in clients:
                client.forget()
            used, began = seconds_of(scope.pid), time.monotonic()
            time.sleep(seconds)
            share = (seconds_of(scope.pid) - used) / (time.monotonic() - began)
            frames = [len(client.messages("frame")) / seconds for client in clients]
            rates = [
                sum(
                    trace["rate"] or 0.0
                    for trace in client.messages("stats")[-1]["traces"].values()
                )
                for client in clients
            ]
            row = (count, 100 * share, min(frames, default=0.0), min(rates, default=0.0))
            print("%5d  %11.1f  %8.1f  %10.0f  %10.1f" % (*row, megabytes_of(scope.pid)))
    finally:
        for client in clients:
            client.close()
        scope.stop()
        for process in (load, master):
            process.terminate()
            process.wait(30.0)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Measure what the scope costs.")
    parser.add_argument("--publish", action="store_true", help="be the node that publishes")
    parser.add_argument("--seconds", type=float, default=20.0, help="time for each row, s")
    arguments = parser.parse_args()
    if arguments.publish:
        publish()
    else:
        measure(arguments.seconds)


if __name__ == "__main__":
    main()
