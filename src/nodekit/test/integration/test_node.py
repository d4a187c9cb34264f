#!/usr/bin/env python3
"""Tests of a Node on a real master: start of callbacks, exclusion, and closing."""

import contextlib
import gc
import itertools
import linecache
import math
import os
import signal
import threading
import time
import tracemalloc
import unittest
from queue import Queue
from typing import Any, Callable, List, Tuple
from unittest import mock

import rosgraph
import rospy
from rosgraph_msgs.msg import Log, TopicStatistics
from std_msgs.msg import Float32, String
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nodekit.executors import SingleThreadedExecutor
from nodekit.managed.managed_node import ManagedNode
from nodekit.messaging import service
from nodekit.node import resource_owner
from nodekit.node.name_rules import IllegalName
from nodekit.node.names import Names
from nodekit.node.ros_node import Node
from nodekit.node.timers import NodeTimer
from nodekit.parameter_server import followed_parameter, live_parameters
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.declaration import (
    FloatParameter,
    ParameterError,
    ParameterSet,
    RateParameter,
    rule,
)
from nodekit.process.host import host_all
from nodekit.process.run import init_node
from nodekit.rospy_internals import incoming_topic, outgoing_topic
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Server
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from nodekit.timing.scheduler import get_scheduler


class Settings(ParameterSet):
    rate = RateParameter(100.0, help="of the timer")
    gain = FloatParameter(1.0, minimum=0.0, help="a gain")


class OnMaster(unittest.TestCase):
    """Each test has its own namespaces in this process."""

    numbers = itertools.count()

    def setUp(self) -> None:
        self.space = f"/space{next(self.numbers)}"
        self.server = Server()

    def node(self, name: str = "one") -> Node:
        """Return a new node, not started, which is closed at the end."""
        node = Node(Names.hosted(self.space, name))
        self.addCleanup(node.close)
        return node

    def registered(self) -> List[Tuple[str, List[str]]]:
        """Return all that is registered in this test's namespace."""
        state = rosgraph.Master("/test").getSystemState()
        return sorted((n, nodes) for part in state for n, nodes in part if self.space in n)

    def wait_for_ticks(self, count: int) -> None:
        """Wait until the timers' thread has had time for a number of calls at 100 Hz."""
        ticks: List[float] = []
        clock = self.node(f"clock{next(self.numbers)}")
        clock.create_timer(100.0, ticks.append)
        clock.start()
        wait_until(lambda: len(ticks) >= count, lambda: f"{len(ticks)} ticks")
        clock.close()

    def publisher(self, topic: str, kind: type = String, **options: Any) -> rospy.Publisher:
        """Return a plain rospy publisher, which needs a connection."""
        publisher = rospy.Publisher(self.space + "/" + topic, kind, queue_size=100, **options)
        self.addCleanup(publisher.unregister)
        return publisher


class Start(OnMaster):
    """Resources are queued until the start."""

    def test_no_callback_begins_before_the_constructor_has_returned(self) -> None:
        calls, wait_for_ticks = [], self.wait_for_ticks  # type: Any
        self.publisher("latched", latch=True).publish("there already")
        self.server.set(self.space + "/one/beside", 5)

        class Eager:
            def __init__(self, node: Node) -> None:
                settings = node.declare_parameters(Settings, on_change=self.call)
                node.create_subscription("latched", String, self.call)
                node.on_parameter("~beside", self.call)
                node.create_timer(1000.0, self.call)
                own = node.create_publisher("own", String, latch=True)
                node.create_subscription("own", String, self.call)
                own.publish("hello")
                node.create_service("~ask", Trigger, self.call)
                settings.update(gain=2.0)
                wait_for_ticks(20)
                calls.append("constructed")

            def call(self, *_: Any) -> None:
                calls.append("callback")

        node = self.node()
        Eager(node)
        self.assertEqual(calls, ["constructed"])
        self.assertEqual([n for n, _ in self.registered() if "/one" in n or "own" in n], [])
        node.start()
        wait_until(lambda: calls.count("callback") > 5, lambda: str(calls))
        self.assertEqual(self.server.get(self.space + "/one/gain"), 2.0)

    def test_objects_created_after_the_start_are_registered_immediately(self) -> None:
        node = self.node()
        node.start()
        heard: List[str] = []
        node.create_service("late", Trigger, lambda request: TriggerResponse(True, "here"))
        node.create_subscription("topic", String, lambda message: heard.append(message.data))
        node.create_publisher("topic", String).publish("news")
        self.assertEqual(heard, ["news"])
        self.assertEqual(rospy.ServiceProxy(self.space + "/late", Trigger)().message, "here")

    def test_objects_closed_during_the_start_are_not_opened(self) -> None:
        for owner, function in (
            (outgoing_topic, "send_directly"),
            (service, "_LoggedService"),
            (incoming_topic, "receive_in_batches"),
            (live_parameters, "open_all"),
            (followed_parameter, "open_all"),
            (NodeTimer, "start_together"),
        ):
            with self.subTest(f"{owner.__name__} {function}"):
                node = self.node(f"{owner.__name__}_{function}".replace(".", "_"))
                settings = node.declare_parameters(Settings)
                node.on_parameter("~beside", lambda value: None)
                node.create_timer(lambda: settings.values.rate, lambda elapsed: None)
                node.create_publisher("~topic", String)
                node.create_subscription("~topic", String, lambda message: None)
                node.create_service("~ask", Trigger, lambda request: TriggerResponse())
                go_on = getattr(owner, function)

                def close_and_go_on(*arguments: Any, **options: Any) -> Any:
                    node.close()
                    return go_on(*arguments, **options)

                with mock.patch.object(owner, function, close_and_go_on):
                    node.start()
                self.assertEqual([n for n, _ in self.registered() if node.name in n], [])
                self.assertEqual([w.key for w in get_watcher()._watched if node.name in w.key], [])
                self.assertEqual(get_scheduler()._timers, set())

    def test_names_are_remapped_once_where_the_new_one_is_remapped_as_well(self) -> None:
        swapped = {"a": "b", "b": "a", "ask": "tell", "tell": "ask", "c": "d", "d": "e"}
        remapped = {f"{self.space}/{old}": f"{self.space}/{new}" for old, new in swapped.items()}
        heard: List[str] = []
        node = self.node()
        with mock.patch.dict(rospy.names.get_resolved_mappings(), remapped):
            node.create_publisher("a", String, latch=True).publish("at b")
            node.create_publisher("c", String, latch=True).publish("at d")
            node.create_subscription("b", String, lambda message: heard.append(message.data))
            node.create_service("ask", Trigger, lambda request: TriggerResponse(True, "here"))
            node.start()
        self.publisher("a", latch=True).publish("at a")
        for name in "bd":
            recorder = MessageRecorder(f"{self.space}/{name}", String)
            self.addCleanup(recorder.close)
            self.assertEqual(recorder.wait_for(lambda message: True).data, f"at {name}")
        wait_until(lambda: heard, lambda: "nothing at a")
        self.assertEqual(heard, ["at a"])
        self.assertEqual(rospy.ServiceProxy(self.space + "/tell", Trigger)().message, "here")

    def test_latched_message_of_the_constructor_reaches_late_subscribers(self) -> None:
        node = self.node()
        state = node.create_publisher("state", String, latch=True)
        state.publish("first")
        state.publish("waiting")
        node.start()
        message = rospy.wait_for_message(self.space + "/state", String, TIMEOUT_S)
        self.assertEqual(message.data, "waiting")

    def test_latched_message_reaches_each_later_subscription_of_the_process(self) -> None:
        node, heard = self.node(), []
        here = node.create_publisher("here", String, latch=True)
        node.start()
        here.publish("here")
        self.publisher("there", latch=True).publish("there")
        for count in (1, 2):
            for topic in ("here", "there"):
                node.create_subscription(topic, String, lambda message: heard.append(message.data))
            expected = sorted(count * ["here", "there"])
            wait_until(lambda expected=expected: sorted(heard) == expected, lambda: str(heard))

    def test_change_between_declaration_and_start_calls_the_listener(self) -> None:
        told: List[Tuple[float, float]] = []
        node = self.node()
        node.declare_parameters(Settings, lambda new, old: told.append((old.gain, new.gain)))
        self.server.set(self.space + "/one/gain", 5.0)
        node.start()
        wait_until(lambda: told, lambda: "nothing is told")
        self.assertEqual(told, [(1.0, 5.0)])

    @extended
    def test_rospys_statistics_count_messages_within_the_process(self) -> None:
        name, recorder = self.space + "/topic", MessageRecorder("/statistics", TopicStatistics)
        self.addCleanup(recorder.close)
        node = self.node()
        node.create_timer(100.0, lambda elapsed: publisher.publish("news"))
        node.create_subscription("topic", String, lambda message: None)
        publisher = node.create_publisher("topic", String)
        # As if the parameter /enable_statistics is set, which is read once in a process.
        logger = rospy.topics.SubscriberStatisticsLogger
        with mock.patch.object(logger, "is_enabled", return_value=True):
            node.start()
        told = recorder.wait_for(lambda one: one.topic == name and one.delivered_msgs > 1)
        self.assertEqual((told.node_pub, told.node_sub), 2 * (rospy.get_name(),))

    def test_arguments_in_rospy_style_are_accepted(self) -> None:
        node = self.node()
        node.create_publisher("a", String, queue_size=10)
        node.create_publisher("b", String, True, 10)
        node.create_subscription("a", String, print, queue_size=1)
        node.start()

    def test_several_refused_parameters_are_named_together(self) -> None:
        self.server.set(self.space + "/one", {"rate": -1, "gain": "x"})
        with self.assertRaises(ParameterError) as caught:
            self.node().declare_parameters(Settings)
        self.assertIn(self.space + "/one/rate: refused -1", str(caught.exception))
        self.assertIn(self.space + "/one/gain: refused 'x'", str(caught.exception))

    def test_parameters_are_declared_once(self) -> None:
        class Others(Settings):
            """Further parameters of the same node."""

        node = self.node()
        part = node.create_scope()
        part.declare_parameters(Settings)
        refused = f"{self.space}/one: parameters: refused Others beside Settings: must all be "
        for again in (node, node.create_scope()):
            with self.assertRaisesRegex(ValueError, refused):
                again.declare_parameters(Others)
        self.node("two").declare_parameters(Others)
        part.close()
        node.declare_parameters(Others)
        node.start()
        self.assertEqual(self.server.get(self.space + "/one/gain"), 1.0)

    def test_rule_of_node_is_checked_at_start_and_each_change(self) -> None:
        class Picky:
            def __init__(self, node: Node) -> None:
                self.node = node
                self.settings = node.declare_parameters(Settings, rules=[self.suits])

            @rule("gain")
            def suits(self, values: Settings) -> None:
                """Reject the value in its name."""
                if values.gain == len(self.node.name):
                    raise ValueError("must not be the length of the node's name")

        long = len(self.space + "/one")
        gain, refused = self.space + "/one/gain", f"/one/gain: refused {long}: must not be the len"
        self.server.set(gain, long)
        with self.assertRaisesRegex(ParameterError, refused):
            Picky(self.node())
        self.server.set(gain, 3.0)
        node = self.node()
        picky = Picky(node)
        node.start()
        with self.assertRaisesRegex(ParameterError, refused):
            picky.settings.update(gain=long)
        self.server.set(gain, long)
        self.server.wait_for(gain, 3.0)
        self.server.delete(gain)
        wait_until(lambda: picky.settings.values.gain == 1.0, lambda: str(picky.settings.values))

    def test_async_callbacks_are_refused(self) -> None:
        async def awaited(*_: Any) -> None:
            pass

        given: Any
        for given, why in ((awaited, "must not be async def"), (None, "must be a function")):
            node = self.node()
            with self.assertRaisesRegex(TypeError, f"/beside: refused .*{why}"):
                node.on_parameter("beside", given)
            with self.assertRaisesRegex(TypeError, f"/one: add_listener: refused .*{why}"):
                node.declare_parameters(Settings).add_listener(given)
            node.close()
        with self.assertRaisesRegex(TypeError, "/one: on_change: refused .*must not be async def"):
            self.node().declare_parameters(Settings, on_change=awaited)


class Callbacks(OnMaster):
    """Callbacks of a node exclude each other unless it asks for something else."""

    def test_callbacks_of_every_type_exclude_each_other(self) -> None:
        """Course err-3."""
        node, kinds, inside, overlaps = self.node(), set(), [0], [0]

        def work(kind: str) -> None:
            inside[0] += 1
            overlaps[0] += inside[0] > 1
            time.sleep(0.002)
            inside[0] -= 1
            kinds.add(kind)

        def serve(_request: Any) -> TriggerResponse:
            work("service")
            return TriggerResponse(True, "")

        settings = node.declare_parameters(Settings, on_change=lambda new, old: work("on_change"))
        node.create_subscription("topic", String, lambda message: work("message"))
        node.create_batch_subscription("topic", String, lambda messages: work("messages"))
        node.create_timer(lambda: settings.values.rate, lambda elapsed: work("timer"))
        node.create_service("serve", Trigger, serve)
        node.on_parameter("beside", lambda value: work("follow"))
        node.start()
        publisher = self.publisher("topic")
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no connection")
        for round_ in range(20):
            publisher.publish("x")
            self.server.set(self.space + "/one/gain", float(round_))
            self.server.set(self.space + "/beside", round_)
            rospy.ServiceProxy(self.space + "/serve", Trigger)()
        wanted = {"service", "on_change", "message", "messages", "timer", "follow"}
        wait_until(lambda: kinds == wanted, lambda: str(kinds))
        self.assertEqual(overlaps[0], 0)

    def test_callbacks_without_a_group_run_during_a_slow_callback(self) -> None:
        node, go_on, inside = self.node(), threading.Event(), threading.Event()
        self.addCleanup(go_on.set)

        def hang(_request: Any) -> TriggerResponse:
            inside.set()
            go_on.wait(TIMEOUT_S)
            return TriggerResponse(True, "")

        node.declare_parameters(Settings)
        latest = node.create_latest_message("topic", String)
        publisher = self.publisher("topic")
        node.create_service("hang", Trigger, hang)
        node.start()
        client = rospy.ServiceProxy(self.space + "/hang", Trigger)
        holder = threading.Thread(target=client)
        holder.start()
        self.assertTrue(inside.wait(TIMEOUT_S))
        self.assertEqual(latest.message, None)
        self.assertEqual(latest.age, math.inf)
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no connection")
        publisher.publish("news")
        wait_until(lambda: latest.message is not None, lambda: "no message")
        self.assertLess(latest.age, TIMEOUT_S)
        answer = rospy.ServiceProxy(self.space + "/one/describe", Trigger)()
        self.assertIn("gain", answer.message)
        go_on.set()
        holder.join(TIMEOUT_S)

    def test_update_in_a_callback_is_in_force_before_on_change_is_called(self) -> None:
        node = self.node()
        order: List[Any] = []
        settings = node.declare_parameters(
            Settings, on_change=lambda new, old: order.append((old.gain, new.gain))
        )

        def serve(_request: Any) -> SetBoolResponse:
            settings.update(gain=3.0)
            order.append(settings.values.gain)
            settings.update(gain=4.0)
            order.append(settings.values.gain)
            return SetBoolResponse(True, "")

        node.create_service("serve", SetBool, serve)
        node.start()
        rospy.ServiceProxy(self.space + "/serve", SetBool)(True)
        wait_until(lambda: len(order) == 3, lambda: str(order))
        self.assertEqual(order, [3.0, 4.0, (1.0, 4.0)])

    def test_update_while_holding_a_lock_of_on_change_does_not_hang(self) -> None:
        node, lock, told = self.node(), threading.Lock(), []  # type: Any

        def on_change(new: Settings, _old: Settings) -> None:
            with lock:
                told.append(new.gain)

        settings = node.declare_parameters(Settings, on_change=on_change)

        def serve(_request: Any) -> TriggerResponse:
            with lock:
                settings.update(gain=2.0)
            return TriggerResponse(True, "")

        node.create_service("serve", Trigger, serve)
        node.start()
        self.server.set(self.space + "/one/gain", 5.0)
        rospy.ServiceProxy(self.space + "/serve", Trigger)()
        wait_until(lambda: told and told[-1] == 2.0, lambda: str(told))

    def test_timer_follows_the_parameter(self) -> None:
        node, calls = self.node(), []  # type: Any
        settings = node.declare_parameters(Settings)
        node.create_timer(lambda: settings.values.rate, calls.append)
        settings.update(rate=0.001)
        node.start()
        wait_until(lambda: calls, lambda: "no first call")
        self.wait_for_ticks(10)
        self.assertEqual(len(calls), 1)
        self.server.set(self.space + "/one/rate", 200.0)
        wait_until(lambda: len(calls) > 10, lambda: str(calls))

    def test_rate_that_cannot_be_asked_for_leaves_the_old_one_and_others_follow(self) -> None:
        node, calls, others = self.node(), [], []  # type: Any
        settings = node.declare_parameters(Settings)
        for bad in (math.inf, math.nan, -1.0):
            with self.assertRaises(ValueError):
                node.create_timer(bad, calls.append)
        node.create_timer(lambda: 100.0 / (settings.values.gain or math.nan), calls.append)
        node.create_timer(lambda: 0.0 if settings.values.gain else 100.0, others.append)
        node.start()
        wait_until(lambda: len(calls) > 3, lambda: str(calls))
        self.assertEqual(others, [])
        settings.update(gain=0.0)
        before = len(calls)
        wait_until(lambda: len(calls) > before + 3, lambda: "the timer has stopped")
        wait_until(lambda: len(others) > 3, lambda: "the other one does not follow")

    def test_messages_that_are_not_finite_are_left_out(self) -> None:
        node, heard = self.node(), []  # type: Any
        node.create_subscription(
            "u", Float32, lambda message: heard.append(message.data), finite=True
        )
        publisher = node.create_publisher("u", Float32)
        node.start()
        for value in (1.0, math.nan, math.inf, 2.0):
            publisher.publish(value)
        self.assertEqual(heard, [1.0, 2.0])

    def test_on_parameter_is_called_at_the_start_and_for_each_change(self) -> None:
        node, told = self.node(), []  # type: Any
        node.on_parameter("text", told.append)
        node.on_parameter("~text", lambda value: told.append(("private", value)))
        node.start()
        self.assertEqual(told, [None, ("private", None)])
        self.server.set(self.space + "/text", "hello")
        wait_until(lambda: "hello" in told, lambda: str(told))
        self.server.delete(self.space + "/text")
        wait_until(lambda: told[-1] is None, lambda: str(told))

    def test_callback_that_raises_harms_no_other(self) -> None:
        node, calls = self.node(), []  # type: Any

        def fail(*_: Any) -> None:
            calls.append(1)
            raise SystemExit

        node.create_timer(100.0, fail)
        node.create_subscription("topic", String, fail)
        publisher = node.create_publisher("topic", String)
        node.start()
        publisher.publish("x")
        wait_until(lambda: len(calls) > 5, lambda: str(calls))


class Forks(OnMaster):
    """A child that is forked in a callback ends with it, and nothing of its parent's."""

    def setUp(self) -> None:
        super().setUp()
        self.children: "Queue[int]" = Queue()

    def fork(self, *_: Any) -> Any:
        """Fork a child that executes the test's function."""
        child = os.fork()
        if not child:
            print("a child")
            return self.in_child()
        self.addCleanup(end, child)
        self.children.put(child)
        return TriggerResponse(True, str(child))

    def in_child(self) -> Any:
        return None

    def assert_child_ends(self, status: int) -> None:
        child = self.children.get(timeout=TIMEOUT_S)
        ended: List[int] = []

        def has_ended() -> bool:
            pid, how = os.waitpid(child, os.WNOHANG)
            ended.extend([os.WEXITSTATUS(how)] if pid else [])
            return bool(pid)

        wait_until(has_ended, lambda: "the child lives on")
        self.assertEqual(ended, [status])

    def test_wherever_it_is_forked(self) -> None:
        node, managed = self.node(), self.node("managed")
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        executing = self.node("executing")
        executor.add_node(executing)
        test = self

        class Managed(ManagedNode):
            def on_configure(self, made: Any) -> None:
                test.fork()

        Managed(managed)
        node.create_subscription("topic", String, self.fork)
        node.create_service("ask", Trigger, self.fork)
        executing.create_subscription("executed", String, self.fork)
        node.on_parameter("key", lambda value: self.fork() if value else None)
        for each in (node, managed, executing):
            each.start()
        plain, executed = self.publisher("topic"), self.publisher("executed")
        for publisher in (plain, executed):
            wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no connection")
        configure = Transition(0, "configure")
        for number, start in enumerate(
            (
                lambda: plain.publish("x"),
                lambda: executed.publish("x"),
                lambda: rospy.ServiceProxy(self.space + "/ask", Trigger)(),
                lambda: self.server.set(self.space + "/key", 1),
                lambda: node.create_timer(0.01, self.fork),
                lambda: rospy.ServiceProxy(self.space + "/managed/change_state", ChangeState)(
                    configure
                ),
            )
        ):
            with self.subTest(number):
                start()
                self.assert_child_ends(0)

    def test_exit_status_of_a_forked_child(self) -> None:
        node = self.node()
        node.create_service("ask", Trigger, self.fork)
        node.start()
        for raised, status in (
            (SystemExit(3), 3),
            (SystemExit(), 0),
            (SystemExit("a text"), 1),
            (ValueError("on purpose"), 1),
            (rospy.ServiceException("on purpose"), 1),
        ):
            with self.subTest(repr(raised)):

                def in_child(error: BaseException = raised) -> None:
                    raise error

                self.in_child = in_child  # type: ignore[method-assign]
                self.assertTrue(rospy.ServiceProxy(self.space + "/ask", Trigger)().success)
                self.assert_child_ends(status)
        # The parent continues, and stays registered.
        self.assertEqual([name for name, _ in self.registered()], [self.space + "/ask"])


def end(child: int) -> None:
    """End a child that is left over."""
    with contextlib.suppress(ProcessLookupError, ChildProcessError):
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


class Texts(OnMaster):
    """Invalid text, as from ``os.fsdecode`` for a name in Latin-1, breaks no other line."""

    NO_TEXT = os.fsdecode(b"caf\xe9")

    def recorder(self, topic: str, kind: type) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def test_a_line_of_the_log_is_escaped(self) -> None:
        recorder = self.recorder("/rosout", Log)
        wait_until(lambda: recorder.publishers() > 0, lambda: "no connection")
        rospy.loginfo("%s %s", self.space, self.NO_TEXT)
        recorder.wait_for(lambda line: line.msg == f"{self.space} caf\\udce9")
        # It is latched: new subscribers get it, and all later messages.
        late = self.recorder("/rosout", Log)
        late.wait_for(lambda line: line.msg == f"{self.space} caf\\udce9")
        rospy.loginfo("%s afterwards", self.space)
        for each in (recorder, late):
            each.wait_for(lambda line: line.msg == f"{self.space} afterwards")

    def test_refused_message_does_not_stop_the_next(self) -> None:
        node, plain = self.node(), self.publisher("plain")
        publisher = node.create_publisher("ours", String)
        node.start()
        for each, topic in ((plain, "plain"), (publisher, "ours")):
            with self.subTest(topic=topic):
                recorder = self.recorder(f"{self.space}/{topic}", String)
                wait_until(lambda: each.get_num_connections() > 0, lambda: "no connection")
                with self.assertRaises(UnicodeEncodeError):
                    each.publish(self.NO_TEXT)
                each.publish("fine")
                self.assertEqual(recorder.wait_for(lambda _: True).data, "fine")

    def test_refused_response_does_not_stop_the_next(self) -> None:
        node, texts = self.node(), [self.NO_TEXT, "fine"]
        node.create_service("ask", Trigger, lambda _: TriggerResponse(True, texts.pop(0)))
        node.start()
        client = rospy.ServiceProxy(self.space + "/ask", Trigger, persistent=True)
        self.addCleanup(client.close)
        with self.assertRaisesRegex(rospy.ServiceException, "surrogates not allowed"):
            client()
        self.assertEqual(client().message, "fine")


class Closing(OnMaster):
    """A node closes the resources that it creates, and leaves none behind."""

    def fill(self, node: Node, maker: Any, calls: Callable[..., Any]) -> None:
        """Make one of everything."""
        maker.create_publisher("out", String, latch=True).publish("x")
        maker.create_subscription("in", String, calls)
        maker.create_batch_subscription("in", String, calls)
        maker.create_latest_message("in", String)
        maker.create_service("~serve", Trigger, lambda request: TriggerResponse(True, ""))
        maker.create_timer(1000.0, calls)
        maker.create_timer(10.0, calls, steady=True)
        maker.on_parameter("beside", calls)
        maker.create_rate_limited_log()
        maker.on_shutdown(lambda: calls())

    def test_nothing_is_called_after_close(self) -> None:
        node, calls = self.node(), []  # type: Any
        closed = threading.Event()
        late: List[Any] = []

        def call(*_: Any) -> None:
            (late if closed.is_set() else calls).append(1)

        settings = node.declare_parameters(Settings, on_change=call)
        self.fill(node, node, call)
        publisher = self.publisher("in")
        node.start()
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no connection")
        wait_until(lambda: len(calls) > 10, lambda: str(len(calls)))
        stop, rounds = threading.Event(), []  # type: Any

        def disturb() -> None:
            for number in itertools.count():
                rounds.append(number)
                publisher.publish("x")
                settings.update(gain=float(number % 7))
                if stop.wait(0.001):
                    break

        thread = threading.Thread(target=disturb)
        thread.start()
        wait_until(lambda: len(rounds) > 10, lambda: f"{len(rounds)} rounds")
        node.close()
        closed.set()
        before = len(rounds)
        wait_until(lambda: len(rounds) > before + 10, lambda: f"{len(rounds)} rounds")
        self.wait_for_ticks(10)
        stop.set()
        thread.join(TIMEOUT_S)
        self.assertEqual(late, [])
        wait_until(
            lambda: [n for n, _ in self.registered()] == [self.space + "/in"],
            lambda: str(self.registered()),
        )
        node.close()
        with self.assertRaises(RuntimeError):
            node.create_publisher("more", String)

    def test_close_waits_for_a_running_callback(self) -> None:
        node, go_on, inside, done = self.node(), threading.Event(), threading.Event(), []

        def serve(_request: Any) -> TriggerResponse:
            inside.set()
            go_on.wait(TIMEOUT_S)
            done.append(True)
            return TriggerResponse(True, "")

        node.create_service("slow", Trigger, serve)
        node.start()
        client = rospy.ServiceProxy(self.space + "/slow", Trigger)
        threading.Thread(target=lambda: self.quietly(client), daemon=True).start()
        self.assertTrue(inside.wait(TIMEOUT_S))
        threading.Timer(0.3, go_on.set).start()
        with mock.patch.object(resource_owner, "CLOSE_WAIT_S", 2.0 * TIMEOUT_S):
            node.close()
        self.assertEqual(done, [True])

    def test_closed_service_ends_lasting_connections_of_its_own_clients_alone(self) -> None:
        clients = []
        for name in ("gone", "here"):
            node = self.node(name)
            node.create_service("~ask", Trigger, lambda _request: TriggerResponse(True, "answer"))
            node.start()
            clients.append(rospy.ServiceProxy(node.name + "/ask", Trigger, persistent=True))
            self.addCleanup(clients[-1].close)
            self.assertEqual(clients[-1]().message, "answer")
            if name == "gone":
                gone = node
        gone.close()
        # A request that overtakes the end of the connection is refused over it.
        self.assertRegex(self.error_of(clients[0]), "transport error|is closed")
        wait_until(
            lambda: "is closed" not in self.error_of(clients[0]), "the end of the connection"
        )
        self.assertEqual(clients[1]().message, "answer")

    def test_close_does_not_wait_for_ever(self) -> None:
        node, inside, go_on, done = self.node(), threading.Event(), threading.Event(), []

        def work(_elapsed: float) -> None:
            inside.set()
            go_on.wait(TIMEOUT_S)
            done.append(True)

        node.create_timer(10.0, work)
        node.start()
        self.assertTrue(inside.wait(TIMEOUT_S))
        node.close()
        self.assertEqual(done, [])
        go_on.set()

    def test_close_does_not_wait_for_its_own_callback(self) -> None:
        node, has_closed = self.node(), threading.Event()

        def close_itself(_elapsed: float) -> None:
            node.close()
            has_closed.set()

        node.create_timer(10.0, close_itself)
        with mock.patch.object(resource_owner, "CLOSE_WAIT_S", 2.0 * TIMEOUT_S):
            node.start()
            self.assertTrue(has_closed.wait(TIMEOUT_S), "it waits for itself")

    @staticmethod
    def error_of(client: Callable[[], Any]) -> str:
        try:
            answer = client()
        except (rospy.ServiceException, rospy.exceptions.TransportException) as error:
            return str(error)
        raise AssertionError(f"a closed service has answered {answer}")

    @staticmethod
    def quietly(client: Callable[[], Any]) -> None:
        try:
            client()
        except rospy.ServiceException:
            pass

    def test_scope_closes_only_its_own_objects(self) -> None:
        node, stays, goes = self.node(), [], []  # type: Any
        node.create_timer(100.0, stays.append)
        node.create_publisher("stays", String)
        part = node.create_scope()
        part.create_timer(100.0, goes.append)
        part.create_publisher("goes", String)
        node.start()
        wait_until(lambda: len(stays) > 3 and len(goes) > 3, lambda: f"{stays} {goes}")
        part.close()
        before = len(stays), len(goes)
        wait_until(lambda: len(stays) > before[0] + 3, lambda: str(stays))
        self.assertEqual(len(goes), before[1])
        names = [name for name, _ in self.registered()]
        self.assertEqual(names, [self.space + "/stays"])

    def test_objects_closed_before_the_start_are_never_opened(self) -> None:
        node = self.node()
        part = node.create_scope()
        part.create_publisher("gone", String)
        part.close()
        node.start()
        self.assertEqual(self.registered(), [])

    @staticmethod
    def settled(facts: Callable[[], Any]) -> Any:
        """Return facts that have not changed for a while: earlier tests leave threads that end."""
        seen = [facts()]

        def is_settled() -> bool:
            time.sleep(0.7)  # rospy looks for closed connections twice a second
            seen.append(facts())
            return bool(seen[-1] == seen[-2])

        wait_until(is_settled, lambda: str(seen[-2:]))
        return seen[-1]

    @extended
    def test_hundred_rounds_leak_nothing(self) -> None:
        publisher = self.publisher("in", latch=True)
        publisher.publish("x")

        def round_() -> None:
            node = Node(Names.hosted(self.space, "one"))
            node.declare_parameters(Settings, on_change=lambda new, old: None)
            heard = threading.Event()
            self.fill(node, node, lambda *_: heard.set())
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            node.start()
            self.assertTrue(heard.wait(TIMEOUT_S))
            rospy.ServiceProxy(self.space + "/one/serve", Trigger)()
            node.close()
            executor.shutdown()

        def facts() -> Tuple[Any, ...]:
            gc.collect()
            state = rosgraph.Master("/test").getSystemState()
            return threading.active_count(), len(os.listdir("/proc/self/fd")), state

        tracemalloc.start()
        self.addCleanup(tracemalloc.stop)
        for _ in range(10):
            round_()
        before = self.settled(facts)
        linecache.clearcache()  # rospy's debug log fills it with the sources of others
        held, first = tracemalloc.get_traced_memory()[0], tracemalloc.take_snapshot()
        for _ in range(90):
            round_()
        wait_until(lambda: facts() == before, lambda: f"{facts()}, not {before}")
        linecache.clearcache()
        grown = tracemalloc.get_traced_memory()[0] - held
        if grown / 90.0 >= 2000.0:
            most = tracemalloc.take_snapshot().compare_to(first, "lineno")[:8]
            self.fail("\n".join([f"{grown / 90.0:.0f} B a round", *map(str, most)]))


class Hosting(OnMaster):
    """Nodes of one process look like separate nodes."""

    class Member:
        def __init__(self, node: Node) -> None:
            self.settings = node.declare_parameters(Settings)
            node.create_publisher("topic", String, latch=True).publish(node.name)
            node.create_service("~ask", Trigger, lambda request: TriggerResponse(True, node.name))

    def test_names_are_those_of_a_node_of_its_own(self) -> None:
        root = self.node("root")
        host_all(root, [("member", self.space + "/a", self.Member)])
        root.host("member", self.space + "/b", self.Member)
        self.assertEqual(self.registered(), [])
        root.start()
        root.host("member", self.space + "/late", self.Member)
        for group in ("a", "b", "late"):
            name = f"{self.space}/{group}/member"
            self.assertEqual(rospy.ServiceProxy(name + "/ask", Trigger)().message, name)
            self.assertEqual(self.server.get(name + "/gain"), 1.0)
            topic = f"{self.space}/{group}/topic"
            self.assertEqual(rospy.wait_for_message(topic, String, TIMEOUT_S).data, name)
        root.close()
        self.assertEqual(self.registered(), [])

    def test_member_that_is_refused_stays_down_alone(self) -> None:
        self.server.set(self.space + "/b/member/gain", -1)
        root = self.node("root")
        up = host_all(root, [("member", self.space + "/" + n, self.Member) for n in "abc"])
        root.start()
        self.assertEqual([node.name[-8:] for node in up], ["a/member", "c/member"])
        self.assertEqual([n for n, _ in self.registered() if self.space + "/b" in n], [])
        with self.assertRaises(ParameterError):
            root.host("member", self.space + "/b", self.Member)

    def test_two_members_of_one_name_are_refused(self) -> None:
        root, name = self.node("root"), self.space + "/a/member"
        twice = [("member", self.space + ends, self.Member) for ends in ("/a", "/b", "/a/")]
        with self.assertRaisesRegex(IllegalName, f"node name '{name}': 2 members use it"):
            host_all(root, twice)
        root.start()
        self.assertEqual(self.registered(), [])


if __name__ == "__main__":
    init_node("test_node")
    rosrun("nodekit", "node", "test_node")
