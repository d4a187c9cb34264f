"""Runs of a coursework without ROS: both nodes are loops in Python, and so is the machine."""

import math
import pathlib
from typing import Any, Callable, Dict, Iterator, List, Optional, Set
from unittest import mock

import pytest
from std_msgs.msg import Float32

from pid_control.programs.node_queries import NodeTopics
from pid_control.signal_judging.coursework_judgement import judge
from pid_control.signal_judging.scenarios import SCENARIO_METRICS, SCENARIOS
from pid_control.signal_runner import trial as trial_module
from pid_control.signal_runner.coursework import find_coursework
from pid_control.signal_runner.signal_bench import SignalBench
from pid_control.signal_runner.signal_session import SignalSession
from pid_control.verdicts.judgement import Judgement
from pid_control.verdicts.limits import read_limits

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
WAVE_LOOPS = PACKAGE / "test" / "courseworks" / "wave_loops"
CONFIG = PACKAGE / "config" / "judge_signals_limits.yaml"
LIMITS = read_limits(CONFIG.read_text("utf-8"), SCENARIO_METRICS)
FLOAT = "std_msgs/Float32"
#: Loop of a program, an iteration for each item.
Loop = Callable[["PlayedNode"], Iterator[None]]


class Machine:
    """Machine of a test: its time, its parameter server, and the nodes that run on it."""

    def __init__(self) -> None:
        self.time, self.now, self.is_simulated = 100.0, 0.0, True
        self.parameters: Dict[str, Any] = {}
        self.nodes: Dict[str, "PlayedNode"] = {}
        #: Loop of each program.
        self.programs: Dict[str, Loop] = {}
        self.bench = PlayedBench(self)
        #: Every command that was started, and names of the nodes that were ended.
        self.commands: List[List[str]] = []
        self.ended: List[str] = []
        #: Time of the clock at each of these starts [s].
        self.started_at: List[float] = []
        #: Number of started nodes from which the machine is late.
        self.late_from = math.inf

    def sleep(self, seconds: float) -> None:
        """Let time pass; nodes by the machine's clock run."""
        for node in self.nodes.values():
            node.spent += node.load * seconds
        end = self.time + seconds + 0.2 * (len(self.commands) > self.late_from)
        while self.time < end:
            self.time = min(self.time + 0.01, end)
            for node in list(self.nodes.values()):
                if node.is_by_machine or not self.is_simulated:
                    node.run(self.time)

    def tick(self, now: float) -> None:
        """Set the simulated clock; nodes by that clock run."""
        self.now = now
        for node in list(self.nodes.values()):
            if not node.is_by_machine:
                node.run(now)


class PlayedNode:
    """Running node, in place of its process; its program is a generator, each turn an iteration."""

    def __init__(self, machine: Machine, command: Any) -> None:
        *argv, name, space = command.argv
        self.machine, self.space = machine, space.partition(":=")[2].rstrip("/")
        self.name = f"{self.space}/{name.partition(':=')[2]}"
        machine.commands.append(command.argv)
        machine.started_at.append(machine.now)
        self.published: Dict[str, str] = {}
        self.subscribed: Dict[str, str] = {}
        self.heard: Dict[str, float] = {}
        self.is_by_machine, self.period, self._due = False, 0.1, -math.inf
        self.status: Optional[int] = None
        self.writes_without_end, self.words = False, ""
        #: Processor time so far [s], and share of the time in which the node computes.
        self.spent = self.load = 0.0
        self.is_restless = False
        self.watch = self
        program = pathlib.Path(argv[-1]).name
        self._loop = machine.programs[program](self)
        machine.nodes[self.name] = self

    def run(self, now: float) -> None:
        """Run the loop if it is due, as rospy.Rate does."""
        if now >= self._due - 1e-6:
            is_late = now > self._due + self.period
            self._due = now + self.period if is_late else self._due + self.period
            next(self._loop)

    def time(self) -> float:
        machine = self.machine
        by_machine = self.is_by_machine or not machine.is_simulated
        return machine.time if by_machine else machine.now

    def get_param(self, name: str, default: Any) -> Any:
        return self.machine.parameters.get(self.resolve(name), default)

    def resolve(self, name: str) -> str:
        return name if name.startswith("/") else f"{self.space}/{name}"

    def publish(self, topic: str, value: float) -> None:
        topic = self.resolve(topic)
        self.published[topic] = FLOAT
        for node in self.machine.nodes.values():
            if topic in node.subscribed:
                node.heard[topic] = value
        self.machine.bench.receive(topic, value)

    def subscribe(self, *topics: str) -> None:
        self.subscribed.update({self.resolve(topic): FLOAT for topic in topics})

    def latest(self, topic: str) -> float:
        return self.heard.get(self.resolve(topic), 0.0)

    # What a trial asks of a process and its watch.

    def busy(self) -> float:
        return sum(node.spent for node in self.machine.nodes.values())

    def processor_time(self) -> float:
        return self.spent

    def has_library(self, name: str) -> bool:
        return False

    def is_idle(self) -> bool:
        return not any(node.is_restless for node in self.machine.nodes.values())

    def has_run(self) -> bool:
        return not self.is_idle()

    def wait_idle(self, longest: float) -> bool:
        self.machine.sleep(0.001 if self.is_idle() else longest)
        return self.is_idle()

    def interrupt(self) -> None:
        self.machine.nodes.pop(self.name, None)

    def end(self) -> None:
        self.interrupt()
        self.machine.ended.append(self.name)

    def last_words(self) -> str:
        return self.words


class PlayedBench(SignalBench):
    """Bench whose topics are the nodes' of a machine."""

    def __init__(self, machine: Machine) -> None:
        with mock.patch("pid_control.signal_runner.signal_bench.init_node", mock.MagicMock()):
            super().__init__()
        self._machine, self._clock = machine, self

    def publish(self, clock: Any) -> None:
        self._machine.tick(clock.clock.to_sec())

    def get_num_connections(self) -> int:
        return len(self._machine.nodes)

    def use_clock(self, is_simulated: bool) -> None:
        super().use_clock(is_simulated)
        self._machine.is_simulated = is_simulated

    def receive(self, topic: str, value: float) -> None:
        if topic in self._subscriptions:
            self._on_message(topic, Float32(value))

    def topics_of(self, node: str) -> Optional[NodeTopics]:
        found = self._machine.nodes.get(node)
        if found is None:
            return None
        return NodeTopics(dict(found.published), dict(found.subscribed))

    def links_of(self, node: str) -> Set[str]:
        nodes = self._machine.nodes
        published = {topic for one in nodes.values() for topic in one.published}
        return published & set(nodes[node].subscribed)


def generator(node: PlayedNode) -> Iterator[None]:
    """Publish a sine and its time, as wave_loops does."""
    amplitude = node.get_param("signal_amplitude", 1.0)
    omega, begin = node.get_param("signal_omega", 1.0), node.time()
    while True:
        time = node.time() - begin
        node.publish("time", time)
        node.publish("signal", amplitude * math.sin(omega * time))
        yield


def process(node: PlayedNode) -> Iterator[None]:
    """Publish the signal with another amplitude and phase, as wave_loops does."""
    node.subscribe("signal", "time")
    names = ("process_angle", "process_offset", "process_amplitude")
    angle, offset, gain = (node.get_param(name, 1.0) for name in names)
    amplitude, omega = (node.get_param(f"signal_{name}", 1.0) for name in ("amplitude", "omega"))
    while True:
        cosine = amplitude * math.cos(omega * node.latest("time"))
        shifted = node.latest("signal") * math.cos(angle) + cosine * math.sin(angle)
        node.publish("proc_signal", gain * shifted + offset)
        yield


class Played:
    """Judgement of a coursework whose programs are loops.

    :ivar machine: the machine, after the end
    :ivar session: the session
    """

    def __init__(
        self,
        patch: "pytest.MonkeyPatch",
        *scenarios: str,
        real_time: bool = False,
        time_limit: float = 600.0,
        **programs: Loop,
    ) -> None:
        self.machine, self._scenarios = Machine(), scenarios or tuple(SCENARIOS)
        self.machine.programs = {"signal_generator.py": generator, "process.py": process}
        self.machine.programs.update({f"{name}.py": loop for name, loop in programs.items()})
        server = self.machine.parameters
        patch.setattr("time.monotonic", lambda: self.machine.time)
        patch.setattr("time.sleep", self.machine.sleep)
        patch.setattr("rospy.get_param_names", lambda: list(server))
        patch.setattr("rospy.get_param", server.__getitem__)
        patch.setattr("rospy.set_param", server.__setitem__)
        patch.setattr("rospy.delete_param", server.pop)
        patch.setattr(trial_module, "ProgramProcess", lambda *_: PlayedNode(self.machine, _[0]))
        coursework = find_coursework(str(WAVE_LOOPS), [], {"PATH": "/usr/bin:/bin"})
        self.session = SignalSession(
            coursework,
            self._scenarios,
            real_time,
            time_limit,
            {},
            mock.Mock(environment={}, pid=0),
            self.machine.bench,
        )

    def judge(self) -> Judgement:
        """Run the trials, and judge them."""
        reason = self.session.run()
        return judge(self.session.evidence, LIMITS, self._scenarios, reason)
