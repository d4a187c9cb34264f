#!/usr/bin/env python3
"""The demos show their lessons: which callbacks overlap, which wait, and on how many threads."""

import os
import threading
import time
import unittest
from typing import Dict, List

import rospy
import yaml
from executors_demo.bars import Bar, bars, most_at_once, overlaps
from executors_demo.events import Event, read
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
#: Longest shutdown after Ctrl-C [s]: below 2 s on an idle machine.
END_S = 10.0
#: Each demo by the name of its node: the program and its parameters.
DEMOS: Dict[str, List[str]] = {
    "single_threaded": [
        "_period:=0.1",
        "_timer1_sleep:=0.05",
        "_timer2_sleep:=0.05",
        "_timer3_sleep:=0.05",
        "_timer4_sleep:=0.1",
    ],
    "mutex_reentrant": ["_threads:=6", "_period:=0.1", "_timer1_sleep:=600"],
    "two_mutex": [
        "_period:=0.1",
        "_timer1_sleep:=1.0",
        "_timer2_sleep:=0.02",
        "_timer3_sleep:=0.02",
        "_timer4_sleep:=0.02",
    ],
    "parallel_node": ["_slow_period:=0.5", "_slow_sleep:=0.3", "_command_sleep:=0.1"],
    "slow_service": ["_service_sleep:=0.5", "_timer_period:=0.1"],
    "exclusive": [
        "slow_service",
        "slow_service:=exclusive_service",
        "_exclusive:=true",
        "_service_sleep:=0.2",
        "_timer_period:=0.05",
    ],
    "several_nodes": [],
    "emergency_stop": ["_executor:=single", "_job_period:=0.1", "_job_sleep:=0.1"],
}


class Demo:
    """A demo that runs.

    :param name: of the node, a key of :data:`DEMOS`
    """

    def __init__(self, name: str) -> None:
        arguments = DEMOS[name]
        program = name
        if arguments and not arguments[0].startswith("_"):
            program, *arguments = arguments
        self.process = Process(os.path.join(SCRIPTS, program), [f"__name:={name}", *arguments])

    def events(self) -> List[Event]:
        """Return its output so far."""
        return list(read(self.process.lines))

    def bars(self) -> List[Bar]:
        """Return its calls so far."""
        return bars(self.events())

    def wait_for(self, one: str, other: str, least: int = 1) -> None:
        """Wait until calls of two callbacks have overlapped."""
        wait_until(
            lambda: overlaps(self.bars(), one, other) >= least,
            lambda: f"{one} does not run beside {other}: {self.bars()[-12:]}",
        )

    def wait_for_calls(self, who: str, count: int) -> None:
        """Wait until calls of a callback have ended."""
        wait_until(
            lambda: sum(not event.begins and event.who == who for event in self.events()) >= count,
            lambda: f"{who} is not called {count} times: {self.bars()[-12:]}",
        )


class Lessons(unittest.TestCase):
    """All demos run at the same time."""

    demos: Dict[str, Demo] = {}

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_lessons")
        cls.demos = {name: Demo(name) for name in DEMOS}

    @classmethod
    def tearDownClass(cls) -> None:
        for demo in cls.demos.values():
            demo.process.end()

    def ended(self, name: str) -> Demo:
        """Press Ctrl-C and return the demo, which has said all by then."""
        demo = self.demos[name]
        self.assertEqual(demo.process.interrupt(), 0)
        self.assertEqual(demo.process.logged("Traceback"), [])
        self.assertEqual(demo.process.error_lines, [])
        return demo

    def assert_never(self, made: List[Bar], *pairs: str) -> None:
        """Assert that callbacks did not overlap, each pair as ``"one other"``."""
        for pair in pairs:
            self.assertEqual(overlaps(made, *pair.split()), 0, pair)

    def test_single_threaded_makes_one_call_at_a_time_until_one_word_is_changed(self) -> None:
        """Course 001-exec-1, 001-exec-7."""
        demo = self.demos["single_threaded"]
        for number in range(1, 5):
            demo.wait_for_calls(f"timer{number}", 2)
        made = demo.bars()
        self.assertEqual(most_at_once(made), 1)
        self.assertEqual(len({bar.thread for bar in made}), 1)
        rospy.set_param("/single_threaded/executor", "multi")
        for other in ("timer1", "timer2", "timer3"):
            demo.wait_for("timer4", other)
        # Each timer has its own group, so its calls never overlap.
        self.assert_never(self.ended("single_threaded").bars(), "timer4 timer4")

    def test_mutex_reentrant_overlaps_itself_in_one_group_until_all_threads_sleep(self) -> None:
        """Course 001-exec-2, 001-exec-4."""
        demo = self.demos["mutex_reentrant"]
        for other in ("timer2", "timer3", "timer4"):
            demo.wait_for("timer1", other)
        wait_until(
            lambda: len({bar.thread for bar in demo.bars() if bar.who == "timer1"}) == 6,
            lambda: f"timer1 does not run beside itself: {demo.bars()[-12:]}",
        )
        began = time.monotonic()
        made = self.ended("mutex_reentrant").bars()
        self.assertLess(time.monotonic() - began, END_S)
        self.assert_never(made, "timer3 timer4", "timer3 timer3", "timer4 timer4")

    def test_two_mutex_a_sleeping_timer1_holds_up_2_but_not_3_and_4(self) -> None:
        """Course 001-exec-3, 001-exec-5."""
        demo = self.demos["two_mutex"]
        demo.wait_for("timer1", "timer3", 3)
        demo.wait_for("timer1", "timer4", 3)
        demo.wait_for_calls("timer2", 2)  # in the end it has its turn
        made = self.ended("two_mutex").bars()
        self.assert_never(made, "timer1 timer2", "timer1 timer1", "timer3 timer4")

    def test_parallel_node_goes_on_and_carries_out_commands_one_by_one(self) -> None:
        """Course 004-exec-1."""
        demo = self.demos["parallel_node"]
        publisher = rospy.Publisher("commands", String, queue_size=10)
        wait_until(
            lambda: publisher.get_num_connections() == 1, lambda: "the node has not subscribed"
        )
        for text in ("left", "right", "stop"):
            publisher.publish(text)
        demo.wait_for_calls("commands", 3)
        demo.wait_for("slow", "fast", 2)

        def together() -> bool:
            publisher.publish("stop")  # on a busy machine it may take more of them
            return overlaps(demo.bars(), "commands", "fast") > 0

        wait_until(together, lambda: str(demo.bars()[-12:]))
        demo = self.ended("parallel_node")
        notes = [event.note for event in demo.events() if event.note]
        self.assertEqual(notes[:3], ["left", "right", "stop"])
        self.assert_never(demo.bars(), "commands commands")

    def call_at_once(self, name: str, count: int) -> List[str]:
        """Call a service from several threads; return the answers."""
        answers: List[str] = []

        def call() -> None:
            answers.append(rospy.ServiceProxy(name, Trigger)().message)

        rospy.wait_for_service(name, TIMEOUT_S)
        threads = [threading.Thread(target=call) for _ in range(count)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return answers

    def test_slow_service_answers_several_at_once_while_its_timer_goes_on(self) -> None:
        """Course 004-exec-2."""
        demo = self.demos["slow_service"]

        def overlapping() -> bool:
            self.assertEqual(self.call_at_once("/slow_service", 3), ["done after 0.5 s"] * 3)
            return overlaps(demo.bars(), "slow_service", "slow_service") >= 3

        wait_until(overlapping, lambda: str(demo.bars()))
        demo.wait_for("slow_service", "timer", 2)
        self.ended("slow_service")

    def test_exclusive_service_answers_one_by_one_while_its_timer_goes_on(self) -> None:
        demo = self.demos["exclusive"]
        answers: List[str] = []

        def beside_the_timer() -> bool:
            answers.extend(self.call_at_once("/exclusive_service", 3))
            return overlaps(demo.bars(), "slow_service", "timer") >= 2

        wait_until(beside_the_timer, lambda: str(demo.bars()[-12:]))
        made = self.ended("exclusive").bars()
        self.assertEqual(sum(bar.who == "slow_service" for bar in made), len(answers))
        self.assert_never(made, "slow_service slow_service")

    def test_several_nodes_share_an_executor(self) -> None:
        """Course 001-exec-6."""
        demo = self.demos["several_nodes"]
        rospy.set_param("/lidar/period", 0.2)
        demo.wait_for("camera", "lidar")
        demo.wait_for("lidar", "planner")
        made = self.ended("several_nodes").bars()
        self.assert_never(made, "camera camera", "lidar lidar", "planner planner")

    def test_emergency_stop_does_not_stand_in_line_with_slow_work(self) -> None:
        """Course 001-exec-8."""
        demo = self.demos["emergency_stop"]
        demo.wait_for_calls("job8", 1)  # by now the last job has waited for all others
        self.assertTrue(rospy.ServiceProxy("/stop", SetBool)(True).success)
        report = rospy.ServiceProxy("/emergency_stop/executor", Trigger)().message
        waited = {entry["kind"]: entry["longest_wait"] for entry in yaml.safe_load(report)}
        self.assertLess(waited["service"], waited["timer"] / 2.0, report)
        calls = len(demo.bars())
        self.assertTrue(rospy.ServiceProxy("/stop", SetBool)(False).success)
        wait_until(lambda: len(demo.bars()) > calls + 3, lambda: "no job goes on")
        self.ended("emergency_stop")


if __name__ == "__main__":
    rosrun("executors_demo", "lessons", Lessons)
