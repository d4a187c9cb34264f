"""Print the observations of the scenarios of ``executor_scenarios`` with rclpy, as JSON."""

import os
import threading
import time
from typing import Any

import rclpy
from rcl_interfaces.srv import ListParameters
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor

from ci.benchmark.executor_scenarios import CALL_S, TICK_S, Observation, Scenario, print_all


def run(number: int, scenario: Scenario, seen: Observation) -> None:
    """Run a node in an executor, and call its service twice at the same time."""

    def answer(request: Any, response: Any) -> Any:
        seen.serve()
        return response

    kinds = {True: ReentrantCallbackGroup, False: MutuallyExclusiveCallbackGroup}
    group = kinds[scenario.is_reentrant]()
    other = group if scenario.is_shared else MutuallyExclusiveCallbackGroup()
    node = rclpy.create_node(f"served{number}")
    node.create_timer(TICK_S, seen.tick, callback_group=other)
    node.create_service(ListParameters, f"slow{number}", answer, callback_group=group)
    caller = rclpy.create_node(f"caller{number}")
    client = caller.create_client(ListParameters, f"slow{number}")
    several = MultiThreadedExecutor(scenario.threads) if scenario.threads > 1 else None
    executors = [several or SingleThreadedExecutor(), SingleThreadedExecutor()]
    for executor, one in zip(executors, (node, caller)):
        executor.add_node(one)
        threading.Thread(target=executor.spin, daemon=True).start()
    client.wait_for_service(timeout_sec=10.0)
    calls = [client.call_async(ListParameters.Request()) for _ in range(2)]
    end = time.monotonic() + 10.0 * CALL_S
    while not all(call.done() for call in calls) and time.monotonic() < end:
        time.sleep(0.01)
    for executor in executors:
        executor.shutdown()


if __name__ == "__main__":
    rclpy.init()
    print_all(run)
    os._exit(0)  # threads of executors that still spin would keep it waiting
