"""Print the observations of the scenarios of ``executor_scenarios`` with nodekit, as JSON."""

from typing import Any

from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from ci.benchmark.executor_scenarios import CALL_S, TICK_S, Observation, Scenario, print_all
from nodekit import (
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    Node,
    ReentrantCallbackGroup,
    init_node,
)

root = init_node("overlap")


def run(number: int, scenario: Scenario, seen: Observation) -> None:
    """Run a node in an executor, and call its service twice at the same time."""

    def answer(request: Any) -> TriggerResponse:
        seen.serve()
        return TriggerResponse(True, "")

    class Served:
        def __init__(self, node: Node) -> None:
            MultiThreadedExecutor(scenario.threads).add_node(node)
            group = (
                MutuallyExclusiveCallbackGroup
                if not scenario.is_reentrant
                else ReentrantCallbackGroup
            )()
            timers = group if scenario.is_shared else MutuallyExclusiveCallbackGroup()
            node.create_timer(1.0 / TICK_S, seen.tick, group=timers)
            node.create_service("slow", Trigger, answer, group=group)

    node = root.host("served", f"/scenario{number}", Served)
    client = root.create_client(node.resolve("slow"), Trigger)
    for call in [client.call_async(TriggerRequest(), 10.0 * CALL_S) for _ in range(2)]:
        call.result()
    node.close()


if __name__ == "__main__":
    root.start()
    print_all(run)
