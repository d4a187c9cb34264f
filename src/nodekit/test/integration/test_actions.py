#!/usr/bin/env python3
"""Tests of actions on a real master, also with stock actionlib."""

import itertools
import os
import threading
import time
import unittest
from typing import Any, Dict, List, Tuple

import actionlib
import actionlib.msg
import rospy
from actionlib.msg import (
    TestAction,
    TestActionGoal,
    TestActionResult,
    TestFeedback,
    TestGoal,
    TestResult,
)
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from rosgraph_msgs.msg import Log

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nodekit import (
    ActionClient,
    CancelResponse,
    GoalError,
    GoalLost,
    GoalRejected,
    GoalResponse,
    GoalState,
    GoalTimeout,
    Group,
    ManagedNode,
    Node,
    NodeScope,
    ServerGoalHandle,
    SingleThreadedExecutor,
)
from nodekit.actions import goal_list
from nodekit.node import action_server
from nodekit.node.names import Names
from nodekit.process.run import init_node
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, hanging
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HELPERS = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "helpers")
STOCK_SERVER = os.path.join(HELPERS, "stock_action_server.py")
NODE = os.path.join(HELPERS, "action_node.py")
#: Goals of the stock server, see there.
SUCCEED, ABORT, REJECT, PEND, RUN, PERSIST = range(6)
LONG_S = 60.0


class Actions(unittest.TestCase):
    """Each test has its own namespace in this process."""

    numbers = itertools.count()

    def setUp(self) -> None:
        self.space = f"/actions{next(self.numbers)}"
        self.node = self.new_node("server")
        self.may_end = threading.Event()
        self.addCleanup(self.may_end.set)
        self.running: Dict[int, ServerGoalHandle] = {}
        self.calls: List[Any] = []

    def new_node(self, name: str) -> Node:
        node = Node(Names.hosted(self.space, name))
        self.addCleanup(node.close)
        node.start()
        return node


class Server(Actions):
    """Our server, with clients of stock actionlib."""

    def execute(self, handle: ServerGoalHandle) -> TestResult:
        """Run until the test lets it end, or a client cancels it."""
        number = handle.request.goal
        self.running[number] = handle
        handle.publish_feedback(TestFeedback(number))
        while not (self.may_end.is_set() or handle.is_cancel_requested):
            self.may_end.wait(0.01)
        if handle.is_cancel_requested:
            handle.canceled(text="stopped")
        else:
            handle.succeed(text="there")
        return TestResult(number + 1)

    def stock_client(self) -> actionlib.ActionClient:
        client = actionlib.ActionClient(f"{self.space}/test", TestAction)
        self.addCleanup(client.stop)
        self.assertTrue(client.wait_for_server(rospy.Duration(TIMEOUT_S)))
        graph, process = Graph(), rospy.get_name()
        for part in ("feedback", "result"):  # to which it may still be connecting
            graph.wait_until_heard(process, f"{self.space}/test/{part}", process)
        return client

    def ended(self, goal: Any, state: int) -> Tuple[int, str]:
        """Wait for the end of a stock client's goal; return its result and text."""
        done = actionlib.CommState.DONE
        wait_until(lambda: goal.get_comm_state() == done, lambda: str(goal.get_comm_state()))
        self.assertEqual(goal.get_terminal_state(), state, goal.get_goal_status_text())
        return goal.get_result().result, goal.get_goal_status_text()

    def is_running(self, *numbers: int) -> None:
        wait_until(lambda: set(numbers) <= set(self.running), lambda: str(self.running))

    def test_simultaneous_goals_have_their_own_feedback_and_results(self) -> None:
        self.node.create_action_server("test", TestAction, self.execute)
        client = self.stock_client()
        fed: List[int] = []
        goals = [
            client.send_goal(
                TestGoal(number), None, lambda _, message: fed.append(message.feedback)
            )
            for number in range(10)
        ]
        self.is_running(*range(10))
        wait_until(lambda: sorted(fed) == list(range(10)), lambda: str(fed))
        self.may_end.set()
        for number, goal in enumerate(goals):
            self.assertEqual(self.ended(goal, GoalState.SUCCEEDED), (number + 1, "there"))

    def test_cancel_by_id_by_time_and_all(self) -> None:
        self.node.create_action_server("test", TestAction, self.execute)
        client = self.stock_client()
        first, second, third, fourth = (client.send_goal(TestGoal(number)) for number in range(4))
        self.is_running(*range(4))
        second.cancel()
        self.assertEqual(self.ended(second, GoalState.PREEMPTED), (2, "stopped"))
        stamp = first.comm_state_machine.action_goal.goal_id.stamp
        client.cancel_goals_at_and_before_time(stamp)
        self.assertEqual(self.ended(first, GoalState.PREEMPTED), (1, "stopped"))
        self.assertTrue(self.running[2].is_active and self.running[3].is_active)
        client.cancel_all_goals()
        for goal in (third, fourth):
            self.ended(goal, GoalState.PREEMPTED)

    def test_goal_cancelled_before_it_arrived_is_recalled(self) -> None:
        self.node.create_action_server("test", TestAction, self.execute)
        client = self.stock_client()
        status = MessageRecorder(f"{self.space}/test/status", GoalStatusArray)
        self.addCleanup(status.close)
        results = MessageRecorder(f"{self.space}/test/result", TestActionResult)
        self.addCleanup(results.close)
        wait_until(results.publishers, lambda: "not connected")
        client.pub_cancel.publish(GoalID(id="early"))
        status.wait_for(lambda array: [one.goal_id.id for one in array.status_list] == ["early"])
        client.pub_goal.publish(TestActionGoal(goal_id=GoalID(id="early")))
        result = results.wait_for(lambda message: message.status.goal_id.id == "early")
        self.assertEqual(result.status.status, GoalState.RECALLED)
        self.assertEqual(self.running, {})

    def test_newest_only_ends_the_earlier_goal_before_the_next_begins(self) -> None:
        holds = threading.Event()
        self.addCleanup(holds.set)

        def execute(handle: ServerGoalHandle) -> TestResult:
            result = self.execute(handle)
            self.calls.append(("end", handle.request.goal))
            holds.wait(LONG_S)
            return result

        self.node.create_action_server("test", TestAction, execute, newest_only=True)
        client = self.stock_client()
        first = client.send_goal(TestGoal(1))
        self.is_running(1)
        second, third = client.send_goal(TestGoal(2)), client.send_goal(TestGoal(3))
        wait_until(lambda: self.calls == [("end", 1)], lambda: str(self.calls))
        self.assertEqual(self.ended(second, GoalState.RECALLED)[1], "another goal was accepted")
        self.assertEqual(set(self.running), {1})
        holds.set()
        self.assertEqual(self.ended(first, GoalState.PREEMPTED), (2, "stopped"))
        self.is_running(3)
        self.may_end.set()
        self.assertEqual(self.ended(third, GoalState.SUCCEEDED), (4, "there"))
        self.assertEqual(set(self.running), {1, 3})

    def test_goal_cancelled_while_it_waits_for_an_earlier_one_never_begins(self) -> None:
        holds = threading.Event()
        self.addCleanup(holds.set)

        def execute(handle: ServerGoalHandle) -> TestResult:
            result = self.execute(handle)
            holds.wait(LONG_S)
            return result

        self.node.create_action_server("test", TestAction, execute, newest_only=True)
        client = self.stock_client()
        first = client.send_goal(TestGoal(1))
        self.is_running(1)
        second = client.send_goal(TestGoal(2))
        wait_until(lambda: self.running[1].is_cancel_requested, lambda: "it goes on")
        client.pub_cancel.publish(second.comm_state_machine.action_goal.goal_id)
        self.ended(second, GoalState.RECALLED)
        holds.set()
        self.ended(first, GoalState.PREEMPTED)
        third = client.send_goal(TestGoal(3))
        self.is_running(3)
        self.assertEqual(set(self.running), {1, 3})
        self.may_end.set()
        self.ended(third, GoalState.SUCCEEDED)

    def test_newest_only_without_execute_callback_preempts_immediately(self) -> None:
        handles: List[ServerGoalHandle] = []
        self.node.create_action_server(
            "test", TestAction, handle_accepted_callback=handles.append, newest_only=True
        )
        client = self.stock_client()
        first = client.send_goal(TestGoal(1))
        wait_until(lambda: len(handles) == 1, lambda: str(handles))
        second = client.send_goal(TestGoal(2))
        self.assertEqual(self.ended(first, GoalState.PREEMPTED), (0, "another goal was accepted"))
        handles[0].succeed(TestResult(9))  # too late, which the node cannot know
        handles[0].publish_feedback(TestFeedback(9))
        wait_until(lambda: len(handles) == 2, lambda: str(handles))
        handles[1].succeed(TestResult(7), "there")
        self.assertEqual(self.ended(second, GoalState.SUCCEEDED), (7, "there"))
        with self.assertRaisesRegex(GoalError, "abort: goal .* has ended before: SUCCEEDED"):
            handles[1].abort()
        with self.assertRaisesRegex(GoalError, "publish_feedback: goal .* SUCCEEDED"):
            handles[1].publish_feedback(TestFeedback(1))

    def test_goal_and_cancel_callbacks_decide(self) -> None:
        def decide(goal: TestGoal) -> Any:
            if goal.goal == 1:
                raise GoalRejected("not 1")
            if goal.goal == 2:
                raise ValueError("no 2")
            return {3: GoalResponse.REJECT, 4: None}.get(goal.goal, GoalResponse.ACCEPT)

        answers = [CancelResponse.ACCEPT, CancelResponse.REJECT]
        self.node.create_action_server(
            "test", TestAction, self.execute, decide, cancel_callback=lambda _: answers.pop()
        )
        client = self.stock_client()
        texts = [
            self.ended(client.send_goal(TestGoal(number)), GoalState.REJECTED)[1]
            for number in (1, 2, 3, 4)
        ]
        self.assertEqual(texts[:3], ["not 1", "ValueError: no 2", "rejected"])
        self.assertIn("returned None: must be GoalResponse.ACCEPT", texts[3])
        goal = client.send_goal(TestGoal(5))
        self.is_running(5)
        goal.cancel()
        wait_until(lambda: len(answers) == 1, lambda: str(answers))
        self.assertFalse(self.running[5].is_cancel_requested)
        goal.cancel()
        self.ended(goal, GoalState.PREEMPTED)

    def test_exception_aborts_the_goal_and_is_logged_with_its_line(self) -> None:
        log = MessageRecorder("/rosout", Log)
        self.addCleanup(log.close)
        wait_until(log.publishers, lambda: "no log")

        def execute(handle: ServerGoalHandle) -> TestResult:
            handle.succeed()
            raise KeyError("on purpose")

        self.node.create_action_server("test", TestAction, execute)
        goal = self.stock_client().send_goal(TestGoal(1))
        self.assertEqual(self.ended(goal, GoalState.ABORTED), (0, "KeyError: 'on purpose'"))
        log.wait_for(lambda line: 'raise KeyError("on purpose")' in line.msg)

    def test_return_value_of_execute_is_checked(self) -> None:
        returned: Dict[int, Any] = {1: None, 2: "text", 3: TestResult("text"), 4: TestResult(4)}
        self.node.create_action_server(
            "test", TestAction, lambda handle: returned[handle.request.goal]
        )
        client = self.stock_client()
        for number, word in (
            (1, "returned without"),
            (2, "TestResult"),
            (3, "int"),
            (4, "succeed()"),
        ):
            goal = client.send_goal(TestGoal(number))
            result, text = self.ended(goal, GoalState.ABORTED)
            self.assertIn(word, text)
            self.assertEqual(result, 4 if number == 4 else 0)

    def test_short_callbacks_are_called_in_the_group_and_execute_outside(self) -> None:
        group, inside = Group(), []

        def execute(handle: ServerGoalHandle) -> None:
            inside.append(group.is_mine)
            handle.succeed(TestResult(1))

        self.node.create_action_server(
            "test", TestAction, execute, lambda _: inside.append(group.is_mine) or True, group=group
        )
        client = self.stock_client()
        with group:
            goal = client.send_goal(TestGoal(1))
            self.assertEqual(inside, [])
        self.ended(goal, GoalState.SUCCEEDED)
        self.assertEqual(inside, [True, False])

    def test_executor_makes_the_short_calls_while_goals_run(self) -> None:
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        executor.add_node(self.node)
        threads: List[str] = []

        def decide(_: TestGoal) -> bool:
            threads.append(threading.current_thread().name)
            return True

        self.node.create_action_server("test", TestAction, self.execute, decide)
        client = self.stock_client()
        goals = [client.send_goal(TestGoal(number)) for number in range(3)]
        self.is_running(0, 1, 2)
        self.assertEqual({name.partition("-")[0] for name in threads}, {"executor"})
        self.may_end.set()
        for goal in goals:
            self.ended(goal, GoalState.SUCCEEDED)

    def test_closing_the_node_ends_its_goals(self) -> None:
        for stubborn, state in ((False, GoalState.PREEMPTED), (True, GoalState.ABORTED)):
            with self.subTest(stubborn=stubborn):
                scope = self.node.create_scope()
                self.running.clear()

                def execute(handle: ServerGoalHandle, stubborn: bool = stubborn) -> TestResult:
                    if not stubborn:
                        return self.execute(handle)
                    self.running[handle.request.goal] = handle
                    self.may_end.wait(LONG_S)
                    handle.succeed()
                    return TestResult(9)

                scope.create_action_server("test", TestAction, execute)
                client = self.stock_client()
                goal = client.send_goal(TestGoal(1))
                self.is_running(1)
                scope.close()
                self.ended(goal, state)
                client.stop()

    def test_goal_that_has_ended_leaves_the_status_after_a_while(self) -> None:
        self.addCleanup(setattr, goal_list, "LISTED_S", goal_list.LISTED_S)
        goal_list.LISTED_S = 0.0
        self.node.create_action_server("test", TestAction, self.execute)
        self.may_end.set()
        self.ended(self.stock_client().send_goal(TestGoal(1)), GoalState.SUCCEEDED)
        status = MessageRecorder(f"{self.space}/test/status", GoalStatusArray)
        self.addCleanup(status.close)
        status.wait_for(lambda array: not array.status_list)

    def test_most_goals_and_the_rest_is_rejected(self) -> None:
        self.addCleanup(setattr, action_server, "MOST_GOALS", action_server.MOST_GOALS)
        action_server.MOST_GOALS = 2
        self.node.create_action_server("test", TestAction, self.execute)
        client = self.stock_client()
        for number in range(2):
            client.send_goal(TestGoal(number))
        self.is_running(0, 1)
        goal = client.send_goal(TestGoal(3))
        self.assertEqual(self.ended(goal, GoalState.REJECTED)[1], "2 goals are running already")


class Managed(Actions):
    """Servers and clients of managed nodes."""

    def change(self, label: str) -> None:
        service = rospy.ServiceProxy(f"{self.space}/server/change_state", ChangeState)
        self.assertTrue(service(Transition(0, label)).success)

    def test_goals_are_taken_only_while_active(self) -> None:
        ends: List[str] = []

        def execute(handle: ServerGoalHandle) -> TestResult:
            self.running[handle.request.goal] = handle
            while not handle.is_cancel_requested:
                self.may_end.wait(0.01)
            ends.append("stopped")
            handle.canceled()
            return TestResult(1)

        class Driver(ManagedNode):
            def on_configure(self, scope: NodeScope) -> None:
                scope.create_action_server("test", TestAction, execute)

        Driver(self.node)
        client = self.new_node("client").create_action_client("test", TestAction)
        self.assertFalse(client.wait_for_server(0.0))
        self.change("configure")
        end = client.send_goal(TestGoal(0), TIMEOUT_S)
        self.assertEqual((end.status, end.text), (GoalState.ABORTED, "the node is not active"))
        self.change("activate")
        handle = client.send_goal_async(TestGoal(1)).result()
        wait_until(lambda: 1 in self.running, lambda: "not running")
        self.change("deactivate")
        self.assertEqual(handle.get_result(TIMEOUT_S).status, GoalState.PREEMPTED)
        self.assertEqual(ends, ["stopped"])
        self.change("cleanup")
        wait_until(lambda: not client.server_is_ready(), lambda: "it is still there")


class Ending(Actions):
    """Nodes that end while goals run."""

    @extended
    def test_goals_end_with_their_process_separate_or_hosted(self) -> None:
        ends = {
            1: (GoalState.PREEMPTED, "", TestResult(5)),
            2: (GoalState.ABORTED, "the node ends", TestResult()),
        }
        for where in ("separate", "hosted"):
            with self.subTest(where):
                server = Process(NODE, [where, f"__ns:={self.space}"])
                self.addCleanup(server.end)
                client = self.node.create_action_client("test", TestAction)
                handles = {
                    number: client.send_goal_async(TestGoal(number), timeout=TIMEOUT_S).result()
                    for number in ends
                }
                results = {
                    number: handle.get_result_async(TIMEOUT_S) for number, handle in handles.items()
                }
                began = time.monotonic()
                self.assertEqual(server.interrupt(), 0)
                self.assertLess(time.monotonic() - began, TIMEOUT_S / 2)
                for number, end in ends.items():
                    self.assertEqual(results[number].result(), end)
                self.assertEqual(server.lines.count("stopped"), 1)
                client.close()


class Client(Actions):
    """Our client, with a server of stock actionlib."""

    def setUp(self) -> None:
        super().setUp()
        self.server = Process(STOCK_SERVER, [f"__ns:={self.space}"])
        self.addCleanup(self.server.end)
        self.client: ActionClient = self.node.create_action_client("test", TestAction)

    def test_every_end(self) -> None:
        ends = {
            number: self.client.send_goal(TestGoal(number), TIMEOUT_S)
            for number in (SUCCEED, ABORT, REJECT)
        }
        self.assertEqual(ends[SUCCEED], (GoalState.SUCCEEDED, "there", TestResult(SUCCEED)))
        self.assertEqual(ends[ABORT], (GoalState.ABORTED, "no way", TestResult(ABORT)))
        self.assertEqual(ends[REJECT], (GoalState.REJECTED, "not this one", TestResult(REJECT)))

    def test_handles_of_simultaneous_goals(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        first, second = (self.client.send_goal_async(TestGoal(RUN)).result() for _ in range(2))
        rejected = self.client.send_goal_async(TestGoal(REJECT)).result()
        self.assertEqual((first.accepted, rejected.accepted), (True, False))
        self.assertEqual(rejected.get_result(TIMEOUT_S).text, "not this one")
        results = [handle.get_result_async(LONG_S) for handle in (first, second)]
        self.assertIn(first.cancel_goal(), (GoalState.PREEMPTING, GoalState.PREEMPTED))
        self.assertEqual(results[0].result().status, GoalState.PREEMPTED)
        self.assertFalse(results[1].done())
        self.client.cancel()
        self.assertEqual(results[1].result().text, "cancelled")
        self.assertEqual(second.cancel_goal(), GoalState.PREEMPTED)

    @extended
    def test_timeouts(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        status = MessageRecorder(f"{self.space}/test/result", TestActionResult)
        self.addCleanup(status.close)
        wait_until(status.publishers, lambda: "not connected")

        def is_accepted_and_has_no_result() -> bool:  # a busy server may accept it too late
            with self.assertRaises(GoalTimeout) as caught:
                self.client.send_goal(TestGoal(RUN), 0.5)
            return "no result within 0.5 s: the goal is cancelled" in str(caught.exception)

        wait_until(is_accepted_and_has_no_result, lambda: "no goal is accepted")
        status.wait_for(lambda message: message.status.status == GoalState.PREEMPTED)
        with self.assertRaisesRegex(GoalTimeout, "no answer of a server within 0.3 s"):
            self.client.send_goal_async(TestGoal(PEND), timeout=0.3).result()
        status.wait_for(lambda message: message.status.status == GoalState.RECALLED)
        handle = self.client.send_goal_async(TestGoal(PERSIST)).result()
        with self.assertRaisesRegex(GoalTimeout, "no result within 0.2 s"):
            handle.get_result(0.2)
        self.assertIs(handle.status, GoalState.ACTIVE)
        missing = self.node.create_action_client("missing", TestAction)
        with self.assertRaisesRegex(GoalTimeout, "/missing: no answer of a server within 0.2 s"):
            missing.send_goal_async(TestGoal(), timeout=0.2).result()
        self.assertFalse(missing.wait_for_server(0.1))

    @extended
    def test_server_that_dies_loses_its_goals(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        handle = self.client.send_goal_async(TestGoal(RUN)).result()
        future = handle.get_result_async(LONG_S)
        self.server.end()
        with self.assertRaisesRegex(GoalLost, "the server has gone"):
            future.result()
        with self.assertRaises(GoalLost):
            handle.cancel_goal()

    @extended
    def test_server_that_starts_again_has_lost_its_goals(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        handle = self.client.send_goal_async(TestGoal(RUN)).result()
        future = handle.get_result_async(LONG_S)
        self.server.end()
        self.server = Process(STOCK_SERVER, [f"__ns:={self.space}"])
        self.addCleanup(self.server.end)
        with self.assertRaises(GoalLost):
            future.result()
        end = self.client.send_goal(TestGoal(SUCCEED), TIMEOUT_S)
        self.assertEqual(end.status, GoalState.SUCCEEDED)

    def test_hanging_server_costs_the_timeout(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        with hanging(self.server.popen.pid):
            with self.assertRaises(GoalTimeout):
                self.client.send_goal(TestGoal(SUCCEED), 0.3)

    def test_callbacks_are_called_in_the_group(self) -> None:
        group = Group()
        client = self.node.create_action_client("test", TestAction, group=group)
        inside: List[Any] = []
        with group:  # as a callback of that group that waits for a result
            end = client.send_goal(TestGoal(SUCCEED), TIMEOUT_S)
            self.assertEqual(end.status, GoalState.SUCCEEDED)
            # One that runs on: feedback that arrives after the result is dropped.
            running = client.send_goal_async(
                TestGoal(RUN),
                lambda message: inside.append(group.is_mine and message.feedback == RUN),
            ).result()
            self.assertEqual(inside, [])
        wait_until(lambda: inside == [True], lambda: str(inside))
        running.cancel_goal_async()
        future = client.send_goal_async(TestGoal(SUCCEED))
        future.add_done_callback(lambda done: inside.append(done.result().accepted))
        wait_until(lambda: inside == [True, True], lambda: str(inside))

    def test_closing_cancels_the_goals(self) -> None:
        self.assertTrue(self.client.wait_for_server(TIMEOUT_S))
        scope = self.node.create_scope()
        handle = scope.create_action_client("test", TestAction).send_goal_async(TestGoal(RUN))
        future = handle.result().get_result_async(LONG_S)
        results = MessageRecorder(f"{self.space}/test/result", TestActionResult)
        self.addCleanup(results.close)
        wait_until(results.publishers, lambda: "not connected")
        scope.close()
        with self.assertRaisesRegex(GoalError, "the client was closed"):
            future.result()
        results.wait_for(lambda message: message.status.status == GoalState.PREEMPTED)


class Silent(Actions):
    """Our client, with a server that leaves something out."""

    @extended
    def test_result_that_is_lost_ends_the_wait(self) -> None:
        client = self.node.create_action_client("test", TestAction)
        server = self.new_node("other")
        status = server.create_publisher("test/status", GoalStatusArray, latch=True)
        for name in ("result", "feedback"):
            server.create_publisher(
                f"test/{name}", getattr(actionlib.msg, f"TestAction{name.title()}")
            )
        server.create_subscription("test/cancel", GoalID, lambda _: None)

        def end(goal: TestActionGoal) -> None:
            status.publish(GoalStatusArray(None, [GoalStatus(goal.goal_id, 3, "there")]))

        server.create_subscription("test/goal", TestActionGoal, end)
        status.publish(GoalStatusArray())
        handle = client.send_goal_async(TestGoal(1)).result()
        self.assertTrue(handle.accepted)
        with self.assertRaisesRegex(GoalLost, "it is SUCCEEDED, but its result was lost"):
            handle.get_result(LONG_S)


class Nested(Actions):
    """Server and client in one process, and in one group."""

    def test_wait_for_a_server_that_waits_for_the_caller_is_refused(self) -> None:
        server = self.node.create_action_server(
            "test", TestAction, lambda handle: handle.succeed(TestResult(1)), lambda _: True
        )
        client = self.node.create_action_client("test", TestAction)
        self.assertEqual(client.send_goal(TestGoal(1), TIMEOUT_S).status, GoalState.SUCCEEDED)
        with self.node.default_group:
            self.assertTrue(server.waits_for_caller())
            with self.assertRaisesRegex(GoalError, "give the server its own group"):
                client.send_goal(TestGoal(1), TIMEOUT_S)
            future = client.send_goal_async(TestGoal(1))
        self.assertTrue(future.result().accepted)

    def test_wrong_arguments_are_refused_at_the_call(self) -> None:
        with self.assertRaisesRegex(TypeError, "must be an action class"):
            self.node.create_action_server("test", TestActionGoal, lambda handle: None)
        with self.assertRaisesRegex(TypeError, "needs an execute_callback"):
            self.node.create_action_server("test", TestAction)
        with self.assertRaisesRegex(TypeError, "must take one argument"):
            self.node.create_action_server("test", TestAction, lambda: None)
        client = self.node.create_action_client("test", TestAction)
        with self.assertRaisesRegex(TypeError, "must be a TestGoal"):
            client.send_goal_async(TestResult())
        with self.assertRaises(TypeError):
            client.send_goal_async(TestGoal("text"))
        for timeout in (0.0, float("nan"), "1"):
            with self.assertRaises(ValueError):
                client.send_goal(TestGoal(1), timeout)


if __name__ == "__main__":
    init_node("test_actions")
    rosrun("nodekit", "actions", "test_actions")
