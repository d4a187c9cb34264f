"""Print what is observed of rclpy's managed nodes, in the cases of ``transitions``, as JSON."""

import contextlib
import itertools
import json
import os
import threading
import time
from typing import Any, Callable, Dict, List, Optional

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

from ci.benchmark import transitions
from lifecycle_msgs import msg, srv

RCLError = rclpy_implementation.RCLError
#: Longest wait for an answer, s.
LIMIT = 10.0
#: How long nothing has to come until all has come, s.
QUIET = 0.02

_numbers = itertools.count()


def callback(name: str) -> Callable[..., Any]:
    """Return a callback that does what is planned for it."""

    def call(self: Any, state: Any) -> Any:
        self.calls.append(name)
        planned = self.plan.get(name, "success")
        if planned == "raise":
            raise RuntimeError("on purpose")
        return getattr(TransitionCallbackReturn, planned.upper())

    return call


class Planned(LifecycleNode):
    """Does what a case plans."""

    on_configure = callback("on_configure")
    on_activate = callback("on_activate")
    on_deactivate = callback("on_deactivate")
    on_cleanup = callback("on_cleanup")
    on_shutdown = callback("on_shutdown")
    on_error = callback("on_error")

    def __init__(self, name: str, plan: Dict[str, str]) -> None:
        self.calls: List[str] = []
        self.plan = plan
        super().__init__(name)


class Asking:
    """Asks one managed node after the other; each is served by a thread of its own."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("asking")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        threading.Thread(target=self.executor.spin, daemon=True).start()

    def call(self, client: Any, request: Any, done: Optional[threading.Event] = None) -> Any:
        """Return the response, None where there is none but something has set ``done``."""
        future = client.call_async(request)
        done = done or threading.Event()
        future.add_done_callback(lambda _: done.set())
        if not done.wait(LIMIT):
            raise TimeoutError(client.srv_name)
        return future.result() if future.done() else None

    def subject(self, plan: Dict[str, str]) -> transitions.Subject:
        """Make a managed node, and clients that ask it."""
        name = f"subject{next(_numbers)}"
        node = Planned(name, plan)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        raised = threading.Event()

        def spin() -> None:
            while True:
                with contextlib.suppress(RCLError):
                    executor.spin()
                    return
                raised.set()

        threading.Thread(target=spin, daemon=True).start()
        events: List[Any] = []
        topic = f"/{name}/transition_event"

        def keep_event(event: Any) -> None:
            events.append([_pair(event.start_state), _pair(event.goal_state)])

        hearing = self.node.create_subscription(msg.TransitionEvent, topic, keep_event, 100)
        kinds = {
            "change_state": srv.ChangeState,
            "get_state": srv.GetState,
            "get_available_states": srv.GetAvailableStates,
            "get_available_transitions": srv.GetAvailableTransitions,
            "get_transition_graph": srv.GetAvailableTransitions,
        }
        clients = {
            each: self.node.create_client(kind, f"/{name}/{each}") for each, kind in kinds.items()
        }
        for client in clients.values():
            client.wait_for_service(LIMIT)
        while not (node.count_subscribers(topic) and self.node.count_publishers(topic)):
            time.sleep(0.01)
        time.sleep(2.0 * QUIET)  # both know of each other, and connect

        def change(number: int, label: str) -> bool:
            request = srv.ChangeState.Request()
            request.transition.id, request.transition.label = number, label
            # Of what is not possible Jazzy's raises an exception, and answers nothing.
            raised.clear()
            answer = self.call(clients["change_state"], request, raised)
            return answer is not None and bool(answer.success)

        def state() -> List[Any]:
            answer = self.call(clients["get_state"], srv.GetState.Request())
            return _pair(answer.current_state)

        def lists() -> List[Any]:
            answer = self.call(clients["get_available_states"], srv.GetAvailableStates.Request())
            states = [_pair(state) for state in answer.available_states]
            return [states, listed("get_transition_graph")]

        def listed(name: str) -> List[Any]:
            answer = self.call(clients[name], srv.GetAvailableTransitions.Request())
            return [
                [_pair(each.transition), _pair(each.start_state), _pair(each.goal_state)]
                for each in answer.available_transitions
            ]

        def close() -> None:
            self.node.destroy_subscription(hearing)
            for client in clients.values():
                self.node.destroy_client(client)
            executor.shutdown()
            node.destroy_node()

        return transitions.Subject(
            change,
            state,
            lambda: listed("get_available_transitions"),
            lists,
            events,
            node.calls,
            close,
        )


def _pair(message: Any) -> List[Any]:
    return [message.id, message.label]


def main() -> None:
    """Observe and print."""
    rclpy.init()
    asking = Asking()
    results = {}
    for name, case in transitions.cases().items():
        subject = asking.subject(case.plan)

        def settle() -> None:
            count = -1
            while count != len(subject.events):
                count = len(subject.events)
                time.sleep(QUIET)

        results[name] = transitions.observe(case, subject, settle)
    print(json.dumps(results), flush=True)
    os._exit(0)  # threads of executors that still spin would keep it waiting


if __name__ == "__main__":
    main()
