"""Print what is observed of the scenarios of ``scenarios`` with rclpy, as JSON."""

import json
import os
import threading
import time
from typing import Any, Dict, List

import rclpy
from rcl_interfaces.srv import ListParameters
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor

from ci.benchmark.scenarios import CALL_S, SCENARIOS, TICK_S, Observation, Scenario


def observe(number: int, scenario: Scenario) -> List[int]:
    """Have a node in an executor, and call its service twice at once."""
    seen = Observation()

    def answer(request: Any, response: Any) -> Any:
        seen.serve()
        return response

    kinds = {True: ReentrantCallbackGroup, False: MutuallyExclusiveCallbackGroup}
    group = kinds[scenario.reentrant]()
    other = group if scenario.shared else MutuallyExclusiveCallbackGroup()
    node = rclpy.create_node(f"served{number}")
    node.create_timer(TICK_S, seen.tick, callback_group=other)
    node.create_service(ListParameters, f"slow{number}", answer, callback_group=group)
    asking = rclpy.create_node(f"asking{number}")
    client = asking.create_client(ListParameters, f"slow{number}")
    executors = [
        MultiThreadedExecutor(scenario.threads)
        if scenario.threads > 1
        else SingleThreadedExecutor(),
        SingleThreadedExecutor(),
    ]
    for executor, one in zip(executors, (node, asking)):
        executor.add_node(one)
        threading.Thread(target=executor.spin, daemon=True).start()
    client.wait_for_service(timeout_sec=10.0)
    calls = [client.call_async(ListParameters.Request()) for _ in range(2)]
    end = time.monotonic() + 10.0 * CALL_S
    while not all(call.done() for call in calls) and time.monotonic() < end:
        time.sleep(0.01)
    for executor in executors:
        executor.shutdown()
    return seen.result()


def main() -> None:
    """Observe and print."""
    rclpy.init()
    results: Dict[str, List[int]] = {}
    for number, (name, scenario) in enumerate(SCENARIOS.items()):
        results[name] = observe(number, scenario)
    print(json.dumps(results), flush=True)
    os._exit(0)  # threads of executors that still spin would keep it waiting


if __name__ == "__main__":
    main()
