"""Print the processor time of a call by rclpy's executors, where work always waits, as JSON.

Usage: ... THREADS
"""

import json
import os
import sys
import time

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from spinning import EVENTS

SECONDS = 3.0


def cpu_of_a_call(executor: Executor, **options: object) -> float:
    """Return the processor time of a call, us; a timer without a period is always ready."""
    node = rclpy.create_node("busy")
    calls = [0]

    def count() -> None:
        calls[0] += 1

    node.create_timer(0.0, count, **options)
    executor.add_node(node)
    end, began = time.monotonic() + SECONDS, time.process_time()
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=1.0)
    used = time.process_time() - began
    executor.shutdown()
    node.destroy_node()
    return used / calls[0] * 1e6


def main() -> None:
    """Measure and print."""
    rclpy.init()
    if EVENTS:
        from rclpy.experimental.events_executor import EventsExecutor

        print(json.dumps({"single_us": cpu_of_a_call(EventsExecutor())}), flush=True)
        os._exit(0)
    figures = {
        "single_us": cpu_of_a_call(SingleThreadedExecutor()),
        "multi_us": cpu_of_a_call(
            MultiThreadedExecutor(int(sys.argv[1])), callback_group=ReentrantCallbackGroup()
        ),
    }
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
