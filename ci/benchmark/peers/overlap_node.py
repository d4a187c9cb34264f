"""Print what is observed of the scenarios of ``scenarios`` with nodekit, as JSON."""

import json
from typing import Any, Dict, List

from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from ci.benchmark.scenarios import CALL_S, SCENARIOS, TICK_S, Observation, Scenario
from nodekit import MultiThreadedExecutor, Node, init_node


def observe(root: Node, number: int, scenario: Scenario) -> List[int]:
    """Have a node in an executor, and call its service twice at once."""
    seen = Observation()

    def answer(request: Any) -> TriggerResponse:
        seen.serve()
        return TriggerResponse(True, "")

    class Served:
        def __init__(self, node: Node) -> None:
            MultiThreadedExecutor(scenario.threads).add_node(node)
            group = node.group(exclusive=not scenario.reentrant)
            node.every(1.0 / TICK_S, seen.tick, group=group if scenario.shared else node.group())
            node.service("slow", Trigger, answer, group=group)

    node = root.host("served", f"/scenario{number}", Served)
    client = root.client(node.resolve("slow"), Trigger)
    for call in [client.call_async(TriggerRequest(), 10.0 * CALL_S) for _ in range(2)]:
        call.result()
    node.close()
    return seen.result()


def main() -> None:
    """Observe and print."""
    root = init_node("overlap")
    root.start()
    results: Dict[str, List[int]] = {}
    for number, (name, scenario) in enumerate(SCENARIOS.items()):
        results[name] = observe(root, number, scenario)
    print(json.dumps(results))


if __name__ == "__main__":
    main()
