"""Print the processor time of a call by rclpy's executors with work always waiting, as JSON.

Usage: ... THREADS
"""

import json
import sys
import time
from typing import Any

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor

SECONDS = 3.0


def cpu_of_a_call(executor: Executor, **options: Any) -> float:
    """Return the processor time of a call [us]; a timer without a period is always ready."""
    node = rclpy.create_node("busy")
    calls = []
    node.create_timer(0.0, lambda: calls.append(None), **options)
    executor.add_node(node)
    end, began = time.monotonic() + SECONDS, time.process_time()
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=1.0)
    used = time.process_time() - began
    executor.shutdown()
    node.destroy_node()
    return used / len(calls) * 1e6


if __name__ == "__main__":
    rclpy.init()
    several, group = MultiThreadedExecutor(int(sys.argv[1])), ReentrantCallbackGroup()
    figures = {
        "single_us": cpu_of_a_call(SingleThreadedExecutor()),
        "multi_us": cpu_of_a_call(several, callback_group=group),
    }
    print(json.dumps(figures))
