"""Print the behaviour of rclpy's managed nodes in the cases of ``lifecycle_cases``, as JSON."""

import contextlib
import itertools
import os
import threading
import time
from typing import Any, Dict, List, Tuple

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node

from ci.benchmark import lifecycle_cases
from lifecycle_msgs import msg, srv

RCLError = rclpy_implementation.RCLError
#: Longest wait for an answer [s].
LIMIT = 10.0
#: Silence after which all events have arrived [s].
QUIET = 0.02

_numbers = itertools.count()
_CALLBACKS = lifecycle_cases.make_callbacks(TransitionCallbackReturn)


class PlannedNode(type("Callbacks", (LifecycleNode,), _CALLBACKS)):
    """Node with callbacks that have the outcomes of a case."""

    def __init__(self, name: str, plan: Dict[str, str]) -> None:
        self.calls: List[str] = []
        self.plan = plan
        super().__init__(name)


class Subject(lifecycle_cases.Subject):
    """A managed node and a node with clients of its services, in a thread each."""

    def __init__(self, plan: Dict[str, str]) -> None:
        super().__init__()
        number = next(_numbers)
        name = f"subject{number}"
        node, caller = PlannedNode(name, plan), rclpy.create_node(f"caller{number}")
        self.calls = node.calls
        topic = f"/{name}/transition_event"
        caller.create_subscription(msg.TransitionEvent, topic, self.add_event, 100)
        self._clients = {
            service: caller.create_client(getattr(srv, kind), f"/{name}/{service}")
            for service, kind in lifecycle_cases.SERVICES.items()
        }
        self._has_raised = threading.Event()
        self._running = [self._run(one) for one in (node, caller)]
        for client in self._clients.values():
            client.wait_for_service(LIMIT)
        while not (node.count_subscribers(topic) and caller.count_publishers(topic)):
            time.sleep(0.01)
        time.sleep(2.0 * QUIET)  # both know of each other, and connect

    def _run(self, node: Node) -> Tuple[Node, SingleThreadedExecutor, threading.Thread]:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        thread = threading.Thread(target=self._spin, args=(executor,), daemon=True)
        thread.start()
        return node, executor, thread

    def _spin(self, executor: SingleThreadedExecutor) -> None:
        while True:
            with contextlib.suppress(RCLError):
                executor.spin()
                return
            self._has_raised.set()

    def call(self, service: str, number: int = 0, label: str = "") -> Any:
        request = getattr(srv, lifecycle_cases.SERVICES[service]).Request()
        if service == "change_state":
            request.transition.id, request.transition.label = number, label
        # Jazzy raises an exception for an impossible transition, and does not answer.
        done = self._has_raised
        done.clear()
        future = self._clients[service].call_async(request)
        future.add_done_callback(lambda _: done.set())
        if not done.wait(LIMIT):
            raise TimeoutError(service)
        return future.result() if future.done() else None

    def settle(self) -> None:
        count = -1
        while count != len(self.events):
            count = len(self.events)
            time.sleep(QUIET)

    def close(self) -> None:
        for node, executor, thread in self._running:
            executor.shutdown()
            thread.join(LIMIT)
            node.destroy_node()


if __name__ == "__main__":
    rclpy.init()
    lifecycle_cases.print_all(Subject)
    os._exit(0)  # threads of executors that still spin would keep it waiting
