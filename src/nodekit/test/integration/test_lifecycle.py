#!/usr/bin/env python3
"""Tests of managed nodes on a real master: transitions, lifetimes of resources, and the end."""

import contextlib
import gc
import io
import itertools
import linecache
import os
import threading
import time
import tracemalloc
import unittest
import weakref
from functools import partial
from typing import Any, Callable, Dict, List, Tuple, Union
from unittest import mock

import rosgraph
import rosnode
import rospy
import yaml
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from lifecycle_msgs.msg import State, Transition, TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    ChangeStateRequest,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from nodekit import (
    FloatParameter,
    LiveParameters,
    ManagedNode,
    MultiThreadedExecutor,
    NestedCall,
    Node,
    NodeScope,
    Outcome,
    ParameterSet,
    SingleThreadedExecutor,
    StringParameter,
    host_all,
    read_once,
)
from nodekit.commands import lifecycle
from nodekit.managed.activation_gate import ManagedPublisher, ManagedTimer
from nodekit.node.clients import call_service
from nodekit.node.names import Names
from nodekit.node.timers import NodeTimer
from nodekit.parameter_server import reconfigure
from nodekit.process.run import init_node
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HERE = os.path.dirname(os.path.realpath(__file__))
DRIVERS = os.path.join(HERE, "..", "helpers", "managed_drivers.py")

#: Id of each request, its start, the state meanwhile, and the goals at success and failure.
REQUESTS = {
    "configure": (1, "unconfigured", "configuring", "inactive", "unconfigured"),
    "cleanup": (2, "inactive", "cleaningup", "unconfigured", "inactive"),
    "activate": (3, "inactive", "activating", "active", "inactive"),
    "deactivate": (4, "active", "deactivating", "inactive", "active"),
}
CELLS = [(label, *row) for label, row in REQUESTS.items()] + [
    ("shutdown", number, start, "shuttingdown", "finalized", "finalized")
    for number, start in enumerate(("unconfigured", "inactive", "active"), 5)
]
#: How to get to a state.
WAYS: Dict[str, List[str]] = {
    "unconfigured": [],
    "inactive": ["configure"],
    "active": ["configure", "activate"],
    "finalized": ["shutdown"],
}
#: The first number of what follows from each callback.
FIRST_IDS = dict(configure=10, cleanup=20, activate=30, deactivate=40, shutdown=50)

Plan = Dict[str, Callable[[], Any]]


def failing() -> bool:
    return False


def raising() -> None:
    raise ValueError("on purpose")


def ending() -> None:
    raise SystemExit(1)


class Settings(ParameterSet):
    gain = FloatParameter(1.0, help="a gain")
    port = read_once(StringParameter("a", help="a port"))


class Driver(ManagedNode):
    """Creates a driver's resources, and executes a test's plan."""

    def __init__(self, node: Node, plan: Plan) -> None:
        super().__init__(node)
        self.plan = plan
        self.called: List[str] = []
        self.ticks: List[str] = []
        self.heard: List[str] = []

    def do(self, name: str) -> Any:
        self.called.append(name)
        return self.plan.get(name, lambda: None)()

    def on_configure(self, made: NodeScope) -> Any:
        self.made = made
        self.publisher = made.create_publisher("out", String)
        self.timer = made.create_timer(100.0, lambda elapsed: self.ticks.append(self.state.label))
        return self.do("on_configure")

    def on_activate(self, made: NodeScope) -> Any:
        self.made = made
        made.create_subscription("in", String, lambda message: self.heard.append(message.data))
        return self.do("on_activate")

    def on_deactivate(self) -> Any:
        return self.do("on_deactivate")

    def on_cleanup(self) -> Any:
        return self.do("on_cleanup")

    def on_shutdown(self) -> Any:
        return self.do("on_shutdown")

    def on_error(self) -> Any:
        return self.do("on_error")


class Managed(unittest.TestCase):
    """Each test has its own namespaces in this process."""

    numbers = itertools.count()

    def driver(self, start: str = "unconfigured", **plan: Callable[[], Any]) -> Driver:
        """Return a managed node in a state, which then follows a plan."""
        self.space = f"/managed{next(self.numbers)}"
        node = Node(Names.hosted(self.space, "driver"))
        self.addCleanup(node.close)
        self.events: List[TransitionEvent] = []
        made = Driver(node, {})
        node.create_subscription("~transition_event", TransitionEvent, self.events.append)
        node.start()
        for label in WAYS[start]:
            self.assertTrue(self.change(label))
        del self.events[:], made.called[:]
        made.plan = plan
        return made

    def call(self, name: str, kind: Any, *arguments: Any) -> Any:
        return rospy.ServiceProxy(f"{self.space}/driver/{name}", kind)(*arguments)

    def change(self, wanted: Union[int, str], label: str = "") -> bool:
        """Ask for a transition by its label, or by its number."""
        if isinstance(wanted, str):
            wanted, label = 0, wanted
        return bool(self.call("change_state", ChangeState, Transition(wanted, label)).success)

    def state(self) -> str:
        state: State = self.call("get_state", GetState).current_state
        self.assertEqual(getattr(State, _constant(state)), state.id)
        return str(state.label)

    def steps(self) -> List[Tuple[int, str, str]]:
        """Return number, start and goal of each event so far."""
        return [
            (event.transition.id, event.start_state.label, event.goal_state.label)
            for event in self.events
        ]

    def registered(self) -> List[str]:
        """Return the topics that others have to do with."""
        state = rosgraph.Master("/test").getSystemState()
        names = {self.space + "/out": "out", self.space + "/in": "in"}
        return sorted(names[name] for part in state for name, _ in part if name in names)


def _constant(state: State) -> str:
    return f"{'PRIMARY' if state.id < 10 else 'TRANSITION'}_STATE_{state.label.upper()}"


class Table(Managed):
    """Requests over the services, and their effects."""

    def test_every_cell(self) -> None:
        for (label, number, start, through, goal, otherwise), by_id in itertools.product(
            CELLS, (True, False)
        ):
            wanted = number if by_id else label
            name, first = f"on_{label}", FIRST_IDS[label]
            for plan, there in (({}, goal), ({name: failing}, otherwise)):
                driver = self.driver(start, **plan)
                with self.subTest(start=start, wanted=wanted, plan=plan):
                    self.assertEqual(self.change(wanted), not plan)
                    self.assertEqual(driver.called, [name])
                    self.assertEqual(driver.previous_state.label, start)
                    then = first + len(plan)
                    self.assertEqual(
                        self.steps(), [(number, start, through), (then, through, there)]
                    )
                    self.assertEqual(self.state(), there)
                driver.node.close()

    def test_every_error(self) -> None:
        after = {
            "": (60, "unconfigured"),
            "failing": (61, "finalized"),
            "raising": (62, "finalized"),
        }
        errors = itertools.cycle([raising, ending, lambda: Outcome.ERROR, lambda: "nonsense"])
        for (label, number, start, through, _, _), (mode, end) in itertools.product(
            CELLS, after.items()
        ):
            name = f"on_{label}"
            on_error = {"": lambda: True, "failing": failing, "raising": raising}[mode]
            driver = self.driver(start, **{name: next(errors), "on_error": on_error})
            with self.subTest(start=start, label=label, on_error=mode):
                self.assertFalse(self.change(label))
                self.assertEqual(driver.called, [name, "on_error"])
                self.assertEqual(
                    self.steps(),
                    [
                        (number, start, through),
                        (FIRST_IDS[label] + 2, through, "errorprocessing"),
                        (end[0], "errorprocessing", end[1]),
                    ],
                )
                self.assertEqual(self.state(), end[1])
                self.assertEqual(self.registered(), [])
            driver.node.close()

    def test_disallowed_transition_is_refused_and_logged(self) -> None:
        allowed = {(start, label): number for label, number, start, *_ in CELLS}
        for start in WAYS:
            driver = self.driver(start)
            ids = [allowed[key] for key in allowed if key[0] == start]
            labels = [key[1] for key in allowed if key[0] == start]
            for number in set(range(12)) | {60, 97, 255}:
                if number not in ids:
                    self.assertFalse(self.change(number), (start, number))
            for label in ("configure", "cleanup", "activate", "deactivate", "shutdown", "create"):
                if label not in labels:
                    with self.assertLogs("rosout", "WARNING") as logged:
                        self.assertFalse(self.change(label), (start, label))
                    self.assertIn(f"{label}", logged.output[0])
                    self.assertIn(f"not allowed in the state {start}", logged.output[0])
            self.assertEqual((driver.called, self.events), ([], []))
            self.assertEqual(self.state(), start)
            driver.node.close()

    def test_label_beats_id(self) -> None:
        self.driver()
        self.assertFalse(self.change(1, "activate"))
        self.assertFalse(self.change(1, "nonsense"))
        self.assertTrue(self.change(3, "configure"))
        self.assertEqual(self.state(), "inactive")

    def test_lists(self) -> None:
        self.driver()
        states = self.call("get_available_states", GetAvailableStates).available_states
        self.assertEqual(
            {state.id: state.label for state in states},
            {
                **{0: "unknown", 1: "unconfigured", 2: "inactive", 3: "active", 4: "finalized"},
                **{10: "configuring", 11: "cleaningup", 12: "shuttingdown", 13: "activating"},
                **{14: "deactivating", 15: "errorprocessing"},
            },
        )
        graph = self.call("get_transition_graph", GetAvailableTransitions).available_transitions
        self.assertEqual(len(graph), 25)
        for start in WAYS:
            driver = self.driver(start)
            expected = [
                TransitionDescription(
                    Transition(number, label),
                    next(state for state in states if state.label == start),
                    next(state for state in states if state.label == through),
                )
                for label, number, begin, through, _, _ in CELLS
                if begin == start
            ]
            found = self.call("get_available_transitions", GetAvailableTransitions)
            self.assertEqual(found.available_transitions, expected)
            for each in expected:
                self.assertIn(each, graph)
            driver.node.close()

    def test_events_are_filled_in_and_state_is_latched(self) -> None:
        self.driver()
        self.assertEqual(self.latched(), State(1, "unconfigured"))
        before = rospy.get_rostime().to_nsec()
        self.assertTrue(self.change("configure"))
        first, second = self.events
        self.assertEqual(first.transition, Transition(1, "configure"))
        self.assertEqual(second.transition, Transition(10, "transition_success"))
        times = [before, first.timestamp, second.timestamp, rospy.get_rostime().to_nsec()]
        self.assertEqual(times, sorted(times))
        self.assertEqual(self.latched(), State(2, "inactive"))

    def latched(self) -> State:
        return rospy.wait_for_message(f"{self.space}/driver/state", State, TIMEOUT_S)

    def test_request_waiting_while_a_callback_ends_the_process_is_refused(self) -> None:
        driver = self.driver("inactive")
        replies: List[bool] = []
        waiting = threading.Thread(target=lambda: replies.append(self.change("activate")))
        group = driver.node.default_group
        with self.assertLogs("rosout", "WARNING") as logged:
            with group:
                waiting.start()
                wait_until(lambda: group._queue, lambda: "the request does not wait")
                driver._managed.lifecycle.shut_down_inside()
            waiting.join(TIMEOUT_S)
        text = f"{driver.node.name}: activate is too late: the node is finalized"
        self.assertEqual(logged.output, [f"WARNING:rosout:{text}"])
        self.assertEqual((replies, driver.called), ([False], ["on_shutdown"]))

    def test_one_transition_at_a_time_while_other_requests_are_answered(self) -> None:
        may_end = threading.Event()
        self.addCleanup(may_end.set)
        self.driver(on_configure=lambda: may_end.wait(TIMEOUT_S))
        replies: List[bool] = []
        slow = threading.Thread(target=lambda: replies.append(self.change("configure")))
        slow.start()
        wait_until(lambda: self.state() == "configuring", self.state)
        with self.assertLogs("rosout", "WARNING") as logged:
            self.assertFalse(self.change("shutdown"))
        self.assertIn("shutdown is not allowed while configure is running", logged.output[0])
        available = self.call("get_available_transitions", GetAvailableTransitions)
        ids = [each.transition.id for each in available.available_transitions]
        self.assertEqual(ids, [10, 11, 12])
        may_end.set()
        slow.join(TIMEOUT_S)
        self.assertEqual((replies, self.state()), ([True], "inactive"))
        self.assertTrue(self.change("shutdown"))

    def test_transition_waits_for_the_default_group(self) -> None:
        driver = self.driver()
        with driver.node.default_group:
            asked = threading.Thread(target=self.change, args=("configure",))
            asked.start()
            wait_until(lambda: not self.claims(), lambda: "not claimed")
            self.assertEqual((self.state(), driver.called), ("unconfigured", []))
        asked.join(TIMEOUT_S)
        self.assertEqual(self.state(), "inactive")

    def claims(self) -> bool:
        """Return whether the table rejects a request, not a running transition."""
        with self.assertLogs("rosout", "WARNING") as logged:
            self.assertFalse(self.change("cleanup"))
        return "is not allowed in the state" in logged.output[0]

    def test_executor_makes_the_calls(self) -> None:
        driver = self.driver(on_configure=lambda: names.append(threading.current_thread().name))
        names: List[str] = []
        executor = MultiThreadedExecutor(2)
        self.addCleanup(executor.shutdown)
        executor.add_node(driver.node)
        self.assertTrue(self.change("configure"))
        self.assertEqual([name.rpartition("-")[0][:9] for name in names], ["executor-"])

    def test_request_refused_by_an_executor_does_not_block_later_ones(self) -> None:
        driver = self.driver()
        executor = SingleThreadedExecutor()
        executor.add_node(driver.node)
        executor.shutdown()
        with self.assertRaisesRegex(rospy.ServiceException, "its executor is shut down"):
            self.change("configure")
        executor.remove_node(driver.node)
        self.assertTrue(self.change("configure"))

    def test_callback_that_waits_for_its_own_transition_gets_an_error(self) -> None:
        driver = self.driver()
        client = driver.node.create_client("~change_state", ChangeState)
        with driver.node.default_group:
            with self.assertRaises(NestedCall):
                client.call(ChangeStateRequest(Transition(0, "configure")))
        self.assertEqual(self.state(), "unconfigured")

    def test_transition_takes_milliseconds(self) -> None:
        self.driver()
        taken: List[float] = []
        for _ in range(50):
            for label in ("configure", "cleanup"):
                began = time.monotonic()
                self.assertTrue(self.change(label))
                taken.append(time.monotonic() - began)
        middle = sorted(taken)[len(taken) // 2]
        print(f"transition: p50 {1e3 * middle:.1f} ms")
        self.assertLess(middle, 0.1)  # one wait too many would be seen on any machine


class Made(Managed):
    """Resources of callbacks live as long as their state, and publish only while active."""

    def test_lives_as_long_as_its_state(self) -> None:
        driver = self.driver()
        expected = {"unconfigured": [], "inactive": ["out"], "active": ["in", "out"]}
        for label in ("configure", "activate", "deactivate", "activate", "deactivate", "cleanup"):
            self.assertTrue(self.change(label))
            self.assertEqual(self.registered(), expected[driver.state.label])
        for start in ("inactive", "active"):
            driver = self.driver(start)
            self.assertTrue(self.change("shutdown"))
            self.assertEqual(self.registered(), [])

    def test_is_registered_only_when_the_callback_has_succeeded(self) -> None:
        seen: List[List[str]] = []
        note: Plan = {
            "on_configure": lambda: seen.append(self.registered()),
            "on_activate": lambda: seen.append(self.registered()),
        }
        self.driver(**note)
        self.assertTrue(self.change("configure"))
        self.assertTrue(self.change("activate"))
        self.assertEqual(seen, [[], ["out"]])

    def test_a_lifetime_within_is_opened_with_the_rest_and_closed_alone(self) -> None:
        within: List[NodeScope] = []
        seen: List[List[str]] = []

        def make() -> None:
            within.append(driver.made.create_scope())
            within[0].create_subscription("in", String, lambda message: None)
            self.assertIsInstance(within[0].create_publisher("out", String), ManagedPublisher)
            seen.append(self.registered())

        driver = self.driver(on_configure=make)
        self.assertTrue(self.change("configure"))
        self.assertEqual((seen, self.registered()), ([[]], ["in", "out"]))
        within[0].close()
        self.assertEqual(self.registered(), ["out"])

    def test_objects_are_closed_if_the_callback_fails_half_way(self) -> None:
        driver = self.driver(on_configure=failing)
        self.assertFalse(self.change("configure"))
        self.assertEqual(self.registered(), [])
        with self.assertRaisesRegex(rospy.ROSException, "closed publisher"):
            driver.publisher.publish("news")
        driver = self.driver("inactive", on_activate=failing)
        self.assertFalse(self.change("activate"))
        self.assertEqual(self.registered(), ["out"])
        driver.plan.clear()
        self.assertTrue(self.change("activate"))
        self.assertEqual(self.registered(), ["in", "out"])

    def test_parameters_are_read_at_each_configuring(self) -> None:
        driver = self.driver()
        gains: List[float] = []
        driver.plan["on_configure"] = lambda: gains.append(
            driver.made.declare_parameters(Settings).values.gain
        )
        for gain in (2.0, 3.0):
            Server().set(f"{driver.node.name}/gain", gain)
            self.assertTrue(self.change("configure"))
            gain, port = yaml.safe_load(self.call("describe", Trigger).message)
            self.assertEqual(gain["takes_effect"], "at once")
            self.assertEqual(port["help"], "a port; takes effect at the next configure")
            if reconfigure.AVAILABLE:  # its topics are heard in any state
                updates = driver.node.name + "/parameter_updates"
                rospy.wait_for_message(updates, rospy.AnyMsg, TIMEOUT_S)
            self.assertTrue(self.change("cleanup"))
            with self.assertRaises(rospy.ServiceException):
                self.call("describe", Trigger)
        self.assertEqual(gains, [2.0, 3.0])
        Server().set(f"{driver.node.name}/gain", "much")
        with self.assertLogs("rosout", "ERROR") as logged:
            self.assertFalse(self.change("configure"))
        self.assertIn("gain", logged.output[0].splitlines()[-1])

    def test_parameters_that_are_read_once_say_when_they_take_effect(self) -> None:
        live = self.driver().node.declare_parameters(Settings)
        self.assert_told_when(live, "start")
        driver = self.driver("inactive")
        made: List[LiveParameters[Settings]] = []

        def make() -> None:
            made.append(driver.made.create_scope().declare_parameters(Settings))

        driver.plan["on_activate"] = make
        self.assertTrue(self.change("activate"))
        self.assert_told_when(made[0], "activate")

    def assert_told_when(self, live: "LiveParameters[Settings]", when: str) -> None:
        with self.assertLogs("rosout", "INFO") as logged:
            live.update(gain=2.0, port=when)
        self.assertIn("gain: 1 -> 2", logged.output[0])
        self.assertFalse("takes effect" in logged.output[0], logged.output)
        self.assertIn(f"port: 'a' -> '{when}', takes effect at the next {when}", logged.output[1])

    def test_failure_to_open_is_an_error(self) -> None:
        taken = "~get_state"

        def make_again() -> None:
            driver.made.create_service(taken, GetState, lambda request: None)

        driver = self.driver(on_activate=make_again)
        self.assertTrue(self.change("configure"))
        with self.assertLogs("rosout", "ERROR") as logged:
            self.assertFalse(self.change("activate"))
        self.assertIn("on_activate failed:\nTraceback", logged.output[0])
        self.assertEqual(driver.called, ["on_configure", "on_activate", "on_error"])
        self.assertEqual(self.state(), "unconfigured")

    def test_errors_are_logged_with_their_traceback(self) -> None:
        self.driver(on_configure=raising)
        with self.assertLogs("rosout", "ERROR") as logged:
            self.assertFalse(self.change("configure"))
        self.assertRegex(logged.output[0], r"/driver: on_configure failed:\n(.*\n)+.*on purpose")

    def heard_out(self) -> List[str]:
        """Return the growing list of the driver's messages that another node receives."""
        heard: List[str] = []
        listener = Node(Names.hosted(self.space, "listener"))
        self.addCleanup(listener.close)
        listener.create_subscription("out", String, lambda message: heard.append(message.data))
        listener.start()
        return heard

    def test_publishes_only_while_active(self) -> None:
        driver = self.driver("inactive")
        heard = self.heard_out()
        publisher: Any = driver.publisher
        with self.assertLogs("rosout", "WARNING") as logged:
            for _ in range(3):
                publisher.publish("too early")
            publisher.publish_all([String("too early")] * 2)
        self.assertEqual((heard, publisher.dropped, len(logged.output)), ([], 5, 1))
        self.assertIn("/out: messages are dropped because the node is not active", logged.output[0])
        driver.plan["on_deactivate"] = lambda: publisher.publish("stop")
        self.assertTrue(self.change("activate"))
        publisher.publish("one")
        publisher.publish_all([String("two")])
        self.assertTrue(self.change("deactivate"))
        with self.assertLogs("rosout", "WARNING"):
            publisher.publish("too late")
        self.assertEqual((heard, publisher.dropped), (["one", "two", "stop"], 6))
        self.assertTrue(self.change("activate"))
        driver.plan.update(on_deactivate=raising, on_error=lambda: publisher.publish("too late"))
        self.assertFalse(self.change("deactivate"))
        self.assertEqual((heard, publisher.dropped), (["one", "two", "stop"], 7))

    def test_last_message_of_a_shutdown_goes_out_where_the_node_was_active(self) -> None:
        for start, expected in (("active", ["stop"]), ("inactive", [])):
            with self.subTest(start):
                driver = self.driver(start)
                heard = self.heard_out()
                driver.plan["on_shutdown"] = partial(driver.publisher.publish, "stop")
                self.assertTrue(self.change("shutdown"))
                self.assertEqual((driver.called, heard), (["on_shutdown"], expected))

    def test_exception_on_activation_leaves_publishers_silent(self) -> None:
        driver = self.driver("inactive", on_activate=raising, on_error=lambda: None)
        publisher: Any = driver.publisher
        self.assertFalse(self.change("activate"))
        with self.assertRaises(rospy.ROSException):  # because it is closed
            publisher.publish("news")

    def test_timers_tick_only_while_active(self) -> None:
        driver = self.driver("inactive", on_deactivate=failing)
        self.assertEqual(driver.ticks, [])
        self.assertTrue(self.change("activate"))
        wait_until(lambda: len(driver.ticks) > 1, lambda: "no ticks")
        self.assertFalse(self.change("deactivate"))
        count = len(driver.ticks)
        wait_until(lambda: len(driver.ticks) > count, lambda: "no ticks any more")
        driver.plan.clear()
        self.assertTrue(self.change("deactivate"))
        with self.assertRaises(ValueError):
            driver.timer.set_rate(-1.0)
        driver.timer.set_rate(200.0)  # from the next activation on
        count, others = len(driver.ticks), []
        driver.node.create_timer(200.0, others.append)  # not managed, with the thread of all timers
        wait_until(lambda: len(others) > 10, lambda: "no ticks")
        self.assertEqual(len(driver.ticks), count)
        self.assertEqual(set(driver.ticks), {"active"})
        self.assertTrue(self.change("activate"))
        wait_until(lambda: len(driver.ticks) > count, lambda: "no ticks after the second time")
        self.assertEqual(set(driver.ticks), {"active"})

    def test_timers_of_the_toolkit_tick_in_any_state(self) -> None:
        driver = self.driver()

        def make_log() -> None:
            driver.made.create_rate_limited_log()

        driver.plan["on_configure"] = make_log
        self.assertTrue(self.change("configure"))
        timers = [each for each in driver.made.callbacks() if isinstance(each, NodeTimer)]
        self.assertEqual([isinstance(each, ManagedTimer) for each in timers], [True, False])

    def test_receives_while_active(self) -> None:
        driver = self.driver("active")
        publisher = driver.node.create_publisher("in", String)
        publisher.publish("one")
        # By the timer's thread, if it is in the group at this moment.
        wait_until(lambda: driver.heard == ["one"], lambda: str(driver.heard))
        self.assertTrue(self.change("deactivate"))
        publisher.publish("two")
        self.assertTrue(self.change("activate"))
        publisher.publish("three")
        wait_until(lambda: driver.heard == ["one", "three"], lambda: str(driver.heard))

    @extended
    def test_many_rounds_leak_nothing(self) -> None:
        driver = self.driver()

        def configure() -> None:
            driver.made.declare_parameters(Settings)
            driver.made.create_scope().create_publisher("out", String)

        def round_() -> None:
            driver.plan["on_configure"] = configure
            for label in ("configure", "activate", "deactivate", "cleanup"):
                self.assertTrue(self.change(label))
            driver.plan["on_configure"] = failing
            self.assertFalse(self.change("configure"))
            driver.plan.clear()
            del driver.called[:], driver.ticks[:], self.events[:]

        def facts() -> Tuple[Any, ...]:
            gc.collect()
            state = rosgraph.Master("/test").getSystemState()
            return threading.active_count(), len(os.listdir("/proc/self/fd")), state

        rounds = int(os.environ.get("LIFECYCLE_ROUNDS", "20"))
        tracemalloc.start()
        self.addCleanup(tracemalloc.stop)
        for _ in range(5):
            round_()
        before = facts()
        linecache.clearcache()  # rospy's debug log fills it with the sources of others
        held = tracemalloc.get_traced_memory()[0]
        for _ in range(rounds):
            round_()

        def has_left_nothing() -> bool:
            (threads, files, state), was = facts(), before
            # Threads of earlier tests may still exist, and end soon.
            return bool(threads <= was[0] and files <= was[1] and state == was[2])

        wait_until(has_left_nothing, lambda: f"{facts()}, not {before}")
        linecache.clearcache()
        grown = tracemalloc.get_traced_memory()[0] - held
        print(f"{rounds} rounds: {grown / rounds:.0f} bytes a round")
        self.assertLess(grown / rounds, 2000.0)


class Unaware:
    """A class that knows nothing of managed nodes."""

    alive: "weakref.WeakSet[Unaware]" = weakref.WeakSet()

    def __init__(self, node: Node) -> None:
        self.alive.add(self)
        self.settings = node.declare_parameters(Settings)
        self.state = node.create_publisher("state", String, latch=True)
        self.state.publish(f"gain {self.settings.values.gain:g}")
        self.publisher = node.create_publisher("out", String)
        node.create_subscription("in", String, self.publisher.publish)
        node.create_timer(100.0, lambda elapsed: self.publisher.publish(f"{elapsed:.2f}"))


class Wanted(Managed):
    """Tests of any class with the parameter ``~managed``."""

    def unaware(self, managed: Any, cls: Callable[[Node], object] = Unaware) -> List[str]:
        """Host a class as a node; return the messages received from it."""
        self.space = f"/managed{next(self.numbers)}"
        Unaware.alive.clear()
        if managed is not None:
            Server().set(self.space + "/driver/managed", managed)
        host = Node(Names.hosted(self.space, "host"))
        self.addCleanup(host.close)
        heard: List[str] = []
        for topic in ("state", "out"):
            host.subscribe(topic, String, lambda message: heard.append(message.data))
        self.nodes = host_all(host, [("driver", self.space, cls)])
        host.start()
        return heard

    def test_created_at_configure_publishes_while_active_and_ends_at_cleanup(self) -> None:
        heard = self.unaware(True)
        with contextlib.closing(Node(Names.hosted(self.space, "other"))) as other:
            publisher = other.create_publisher("in", String)
            other.start()
            Server().set(self.space + "/driver/gain", 2.0)  # read when it is configured
            others = self.registered()
            self.assertEqual(len(Unaware.alive), 0)
            for gain in ("2", "3", "3"):
                self.assertTrue(self.change("configure"))
                self.assertEqual(self.registered(), sorted([*others, "in", "out"]))
                with self.assertLogs("rosout", "WARNING") as logged:
                    publisher.publish("too early")
                self.assertIn("/out: messages are dropped because the node", logged.output[0])
                self.assertEqual(heard, [])
                self.assertTrue(self.change("activate"))
                wait_until(lambda: len(heard) > 2, lambda: str(heard))
                self.assertEqual(heard[:2], [f"gain {gain}", "0.00"])
                publisher.publish("one")
                wait_until(lambda: "one" in heard, lambda: str(heard))
                self.assertTrue(self.change("deactivate"))
                self.assertTrue(self.change("cleanup"))
                gc.collect()
                self.assertEqual(self.registered(), others)
                # The scheduler's thread holds the timer that has ticked last.
                self.assertLessEqual(len(Unaware.alive), 1)
                Server().set(self.space + "/driver/gain", 3.0)
                heard.clear()

    def test_has_a_last_word_whenever_it_is_active_no_longer(self) -> None:
        def talkative(node: Node) -> object:
            publisher = node.create_publisher("out", String)
            node.before_deactivate(lambda: publisher.publish("stop"))
            node.create_timer(100.0, lambda elapsed: publisher.publish("go"))
            return publisher

        heard = self.unaware(True, talkative)
        for _ in range(2):
            self.assertTrue(self.change("configure"))
            for _ in range(2):
                heard.clear()
                self.assertTrue(self.change("activate"))
                wait_until(lambda: "go" in heard, lambda: str(heard))
                self.assertTrue(self.change("deactivate"))
                wait_until(lambda: "stop" in heard, lambda: str(heard))
                self.assertEqual((heard.count("stop"), heard[-1]), (1, "stop"))
            heard.clear()
            self.assertTrue(self.change("cleanup"))
        self.assertEqual(heard, [])  # it was not active
        for label in ("configure", "activate", "shutdown"):
            self.assertTrue(self.change(label))
        wait_until(lambda: "stop" in heard, lambda: str(heard))
        self.assertEqual((heard.count("stop"), heard[-1]), (1, "stop"))

    def test_refused_parameters_leave_it_unconfigured(self) -> None:
        self.unaware(True)
        others = self.registered()
        Server().set(self.space + "/driver/gain", "much")
        with self.assertLogs("rosout", "ERROR") as logged:
            self.assertFalse(self.change("configure"))
        sentence = f"parameter {self.space}/driver/gain: refused 'much': must be a number"
        self.assertIn(sentence, logged.output[0])
        self.assertNotIn("Traceback", logged.output[0])
        self.assertEqual((self.state(), self.registered()), ("unconfigured", others))
        Server().set(self.space + "/driver/gain", 4.0)
        self.assertTrue(self.change("configure"))

    def test_unsupported_object_of_a_managed_node_is_refused_with_a_message(self) -> None:
        def hosting(node: Node) -> object:
            return node.host("guest", self.space, Unaware)

        def hosting_many(node: Node) -> object:
            return host_all(node, [("guest", self.space, Unaware)])

        def executing(node: Node) -> object:
            executor = SingleThreadedExecutor()
            self.addCleanup(executor.shutdown)
            executor.add_node(node)
            return executor

        for cls, reason in (
            (hosting, "hosts another node"),
            (hosting_many, "hosts another node"),
            (executing, "has its own executor"),
        ):
            with self.subTest(cls.__name__):
                self.unaware(True, cls)
                others = self.registered()
                for _ in range(2):
                    with self.assertLogs("rosout", "ERROR") as logged:
                        self.assertFalse(self.change("configure"))
                    (line,) = logged.output
                    name = f"{self.space}/driver"
                    self.assertIn(
                        f"parameter {name}/managed: refused True: must be false for a class that "
                        f"{reason}; {name} stays unconfigured",
                        line,
                    )
                    self.assertEqual((self.state(), self.registered()), ("unconfigured", others))

    def test_is_as_ever_where_it_is_not_wanted(self) -> None:
        for managed in (None, False):
            with mock.patch.object(rospy, "logwarn") as warn:
                heard = self.unaware(managed)
            warn.assert_not_called()  # of a parameter that is not used
            wait_until(lambda: len(heard) > 2, lambda: str(heard))
            self.assertEqual(heard[0], "gain 1")
            self.assertNotIn(self.space + "/driver/get_state", Server().services())

    def test_non_boolean_managed_parameter_is_refused(self) -> None:
        with self.assertLogs("rosout", "ERROR") as logged:
            self.unaware("maybe")
        sentence = f"parameter {self.space}/driver/managed: refused 'maybe': must be true or false"
        self.assertIn(sentence, logged.output[0])
        self.assertEqual(self.nodes, [])

    def test_class_of_a_managed_node_is_that_itself_and_reads_late(self) -> None:
        read: List[float] = []

        class Aware(ManagedNode):
            def on_configure(self, made: NodeScope) -> None:
                read.append(made.declare_parameters(Settings).values.gain)

        self.unaware(True, Aware)
        Server().set(self.space + "/driver/gain", 5.0)
        self.assertTrue(self.change("configure"))
        self.assertEqual(read, [5.0])


class Heartbeat(Managed):
    """Heartbeats as a manager receives them."""

    def test_heartbeat_continues_in_any_state_and_during_long_callbacks(self) -> None:
        driver = self.driver()
        recorder = MessageRecorder(f"{self.space}/driver/heartbeat", Header)
        self.addCleanup(recorder.close)
        beats = [recorder.wait_for(lambda beat: True)]
        go_on = threading.Event()
        self.addCleanup(go_on.set)
        # It has the thread that all other timers of this process share, and the node's group.
        driver.node.create_timer(1.0, lambda elapsed: go_on.wait(2 * TIMEOUT_S))
        wait_until(lambda: driver.node.default_group._holder, lambda: "the timer's call")
        beats.append(recorder.wait_for(lambda beat: beat.seq > beats[-1].seq + 1))
        go_on.set()
        for label in ("configure", "activate", "shutdown"):
            self.assertTrue(self.change(label))
            seen = recorder.count()
            wait_until(lambda: recorder.count() > seen, lambda: f"no heartbeat after {label}")
        beats += recorder.messages()[-1:]
        # As many as fit in at 5 Hz, by the stamps; a busy machine leaves some out.
        lasted = (beats[-1].stamp - beats[0].stamp).to_sec()
        self.assertLess(beats[-1].seq - beats[0].seq, 5.0 * lasted + 1.5)

    def test_heartbeat_of_a_closed_node_stops(self) -> None:
        self.driver().node.close()
        self.driver()
        recorder = MessageRecorder(f"{self.space}/driver/heartbeat", Header)
        self.addCleanup(recorder.close)
        with mock.patch.object(rospy, "logerr") as failed:
            wait_until(lambda: recorder.count() > 2, lambda: "no heartbeat")
        failed.assert_not_called()  # as with a closed publisher


class Command(Managed):
    """Output and exit status of ``rosrun nodekit lifecycle``, as of ``ros2 lifecycle``."""

    def typed(self, verb: str, *words: str) -> Tuple[int, str, str]:
        """Return exit status, output and errors, without the namespace of this test.

        Called in this process, as Python takes longer to start; the tutorial types it.
        """
        out, err = io.StringIO(), io.StringIO()
        status: Any = 0
        patient = partial(call_service, timeout=TIMEOUT_S)  # as a busy machine needs
        with mock.patch("sys.argv", ["lifecycle", verb, *words]), mock.patch.object(
            lifecycle, "call_service", patient
        ):
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                try:
                    lifecycle.main()
                except SystemExit as end:
                    status = end.code
        if isinstance(status, str):  # as Python itself does it
            err.write(status + "\n")
            status = 1
        texts = [stream.getvalue().replace(self.space, "") for stream in (out, err)]
        return status or 0, texts[0], texts[1]

    def test_nodes_and_their_states(self) -> None:
        self.driver("inactive")
        node = self.space + "/driver"
        status, out, _ = self.typed("nodes")
        self.assertEqual((status, "/driver" in out.splitlines()), (0, True), out)
        self.assertEqual(self.typed("get", node), (0, "inactive [2]\n", ""))
        status, out, _ = self.typed("get")
        self.assertEqual((status, "/driver: inactive [2]" in out.splitlines()), (0, True), out)
        status, out, err = self.typed("get", self.space + "/drive")
        self.assertEqual((status, out), (1, ""))
        self.assertIn("lifecycle: /drive is not a managed node; there is /driver", err)
        with mock.patch.object(lifecycle, "MasterClient", side_effect=KeyboardInterrupt):
            self.assertEqual(self.typed("get", node), (130, "", ""))

    def test_node_that_does_not_answer_is_named_and_leaves_a_status(self) -> None:
        self.driver("inactive")
        mute = self.space + "/mute"
        # Its lifecycle services exist, and all else is missing.
        service = rospy.Service(mute + "/get_transition_graph", GetAvailableTransitions, None)
        self.addCleanup(service.shutdown)
        status, out, err = self.typed("get")
        self.assertEqual((status, "/driver: inactive [2]" in out.splitlines()), (1, True), out)
        self.assertIn("lifecycle: /mute does not answer: /mute/get_state cannot be called", err)
        for words in (["get", mute], ["list", mute], ["set", mute, "configure"]):
            with self.subTest(words):
                status, out, err = self.typed(*words)
                self.assertEqual((status, out), (1, ""))
                self.assertIn("lifecycle: /mute does not answer: /mute/", err)

    def test_transitions(self) -> None:
        self.driver("active")
        node = self.space + "/driver"
        expected = "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
        expected += "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n"
        self.assertEqual(self.typed("list", node), (0, expected, ""))
        status, out, _ = self.typed("list", node, "--all")
        self.assertEqual((status, out.count("Goal: ")), (0, 25))

    def test_set(self) -> None:
        driver = self.driver(on_activate=failing)
        node = self.space + "/driver"
        refusal = (
            "lifecycle: /driver: activate is not allowed in the state unconfigured; "
            "allowed: configure [1], shutdown [5]\n"
        )
        self.assertEqual(self.typed("set", node, "activate"), (1, "", refusal))
        self.assertEqual(driver.called, [])
        self.assertEqual(self.typed("set", node, "1"), (0, "Transitioning successful\n", ""))
        failed = "lifecycle: activate has failed: /driver is inactive, and its log says why\n"
        self.assertEqual(self.typed("set", node, "activate"), (1, "", failed))
        unknown = self.typed("set", node, "²")
        self.assertIn("lifecycle: /driver: transition '²' is not allowed", unknown[2])
        endless = self.typed("set", node, "activate", "--timeout", "nan")
        text = "lifecycle: timeout: refused nan s: must be a number in (0, 1e+09]\n"
        self.assertEqual(endless, (1, "", text))
        self.assertEqual(driver.called, ["on_configure", "on_activate"])


class Ends(unittest.TestCase):
    """Processes of managed nodes, from the outside."""

    def start(self, *names: str) -> Process:
        """Start a process with nodes of these names, and wait for them."""
        process = Process(DRIVERS, [*names, f"__name:={names[0]}_host"])
        self.addCleanup(process.end)
        for name in names:
            rospy.wait_for_service(f"/{name}/change_state", TIMEOUT_S)
        return process

    def change(self, name: str, label: str) -> bool:
        proxy = rospy.ServiceProxy(f"/{name}/change_state", ChangeState)
        return bool(proxy(Transition(0, label)).success)

    def test_interrupt_leads_through_shutdown_from_any_state(self) -> None:
        process = self.start(*WAYS)
        for name, way in WAYS.items():
            for label in way:
                self.assertTrue(self.change(name, label))
        process.wait_for_log("finalized gets True")
        del process.lines[:]  # the finalized node was shut down before
        self.assertEqual(process.interrupt(), 0)
        expected = {f"{name} was {name}" for name in WAYS if name != "finalized"}
        # Clients still work then.
        expected |= {f"{name} gets True" for name in WAYS if name != "finalized"}
        ends = [f"{name} ends with True" for name in reversed(WAYS)]  # the latest given first
        lines = [line for line in process.lines if "[" not in line]
        self.assertEqual((lines[: len(WAYS)], set(lines[len(WAYS) :])), (ends, expected))
        self.assertEqual(process.logged("ends without"), [])

    @extended
    def test_node_with_the_port_of_a_killed_one_goes_on_when_that_is_replaced(self) -> None:
        process = self.start("bystander")
        master = rosgraph.Master("/killed_before")
        uri = rosgraph.Master("/test").lookupNode("/bystander_host")
        master.registerSubscriber("/nothing", "std_msgs/String", uri)
        self.addCleanup(master.unregisterSubscriber, "/nothing", "http://localhost:1")
        master.registerSubscriber("/nothing", "std_msgs/String", "http://localhost:1")
        process.wait_for_log("request to end /killed_before: its former port is now that of /byst")
        self.assertTrue(self.change("bystander", "configure"))
        rosnode.kill_nodes(["/bystander_host"])  # a request to itself is not ignored
        self.assertEqual(process.wait(), 0)

    @extended
    def test_node_that_ends_its_process_in_a_callback_goes_through_shutdown_too(self) -> None:
        process = self.start("quitting", "active")
        self.assertTrue(self.change("quitting", "configure"))
        self.ask_and_forget("quitting", "activate")
        self.assertEqual(process.wait(), 1)
        of_its_own = [line for line in process.lines if line.startswith("quitting ")]
        expected = ["quitting configures", "quitting ends with True", "quitting was active"]
        self.assertEqual(of_its_own, [*expected, "quitting gets True", "quitting stops"])
        self.assertIn("active was unconfigured", process.lines)
        self.assertEqual(process.logged("ends without"), [])

    @extended
    def test_node_that_ends_its_process_in_a_callback_and_hangs_then_is_left_behind(self) -> None:
        process = self.start("stuck", "active")
        self.assertTrue(self.change("stuck", "configure"))
        self.ask_and_forget("stuck", "activate")
        self.assertEqual(process.wait(), 1)
        for line in ("stuck was active", "active was unconfigured"):
            self.assertIn(line, process.lines)
        text = "/stuck ends without its shutdown: it is shuttingdown, and still busy after 5 s"
        self.assertEqual(len(process.logged(text)), 1, process.error_lines)
        self.assertEqual(len(process.logged("ends without")), 1)

    @extended
    def test_node_that_ends_its_process_during_a_transition_is_logged(self) -> None:
        process = self.start("ending", "active")
        self.ask_and_forget("ending", "configure")
        self.assertEqual(process.wait(), 0)
        self.assertIn("active was unconfigured", process.lines)
        text = "/ending ends without its shutdown: it is configuring, and still busy after 0 s"
        self.assertEqual(len(process.logged(text)), 1, process.error_lines)

    @extended
    def test_rosnode_kill_does_too_and_abandons_hung_callbacks(self) -> None:
        process = self.start("killed", "configuring", "hanging")
        asked = ("configuring", "configure")
        threading.Thread(target=self.ask_and_forget, args=asked, daemon=True).start()
        process.wait_for_log("configuring configures")
        Graph().kill("/killed_host")
        self.assertEqual(process.wait(), 0)
        for line in ("killed was unconfigured", "killed gets True", "hanging was unconfigured"):
            self.assertIn(line, process.lines)
        text = "{0} ends without its shutdown: it is {1}, and still busy after 5 s"
        for name, state in (("/configuring", "configuring"), ("/hanging", "shuttingdown")):
            self.assertEqual(len(process.logged(text.format(name, state))), 1, process.error_lines)
        self.assertEqual(len(process.logged("ends without")), 2)

    def ask_and_forget(self, name: str, label: str) -> None:
        with contextlib.suppress(rospy.ServiceException):
            self.change(name, label)


if __name__ == "__main__":
    init_node("test_lifecycle")
    rosrun("nodekit", "lifecycle", "test_lifecycle")
