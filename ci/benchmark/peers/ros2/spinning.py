"""Spins a node of rclpy, by the executor that the benchmark names in BENCH_EXECUTOR."""

import contextlib
import os
import signal
import threading

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

#: Whether it is the one that is called by what happens, in place of asking what is ready.
EVENTS = os.environ.get("BENCH_EXECUTOR") == "events"


def spin(node: Node) -> None:
    """Spin a node until rclpy is shut down."""
    if EVENTS:
        from rclpy.experimental.events_executor import EventsExecutor

        executor = EventsExecutor()
        executor.add_node(node)
        executor.spin()
    else:
        rclpy.spin(node)


def spin_until_interrupted(node: Node) -> None:
    """Spin a node until Ctrl-C."""
    if EVENTS:  # it does not heed signals, and its thread never ends
        interrupted = threading.Event()
        threading.Thread(target=spin, args=(node,), daemon=True).start()
        signal.signal(signal.SIGINT, lambda *_: interrupted.set())
        while not interrupted.wait(0.05):
            pass
        os._exit(0)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        spin(node)
