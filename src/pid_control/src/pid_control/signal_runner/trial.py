"""Trial: both nodes of a student, started, connected, and run for a time."""

import contextlib
import time
from types import TracebackType
from typing import Any, Dict, List, Mapping, Optional, Sequence, Type

import rospy

from pid_control.programs.deferred_signals import deferred_signals
from pid_control.programs.node_queries import NodeTopics
from pid_control.programs.package_messages import MessageTypeError
from pid_control.programs.private_master import PrivateMaster
from pid_control.programs.program_process import ProgramProcess
from pid_control.runner.clock import Clock, SimulatedClock, WallClock
from pid_control.runner.failure_detection import BusyDetector, failure_of
from pid_control.runner.judging_errors import TimeLimitExceeded
from pid_control.signal_runner.coursework import StudentNode
from pid_control.signal_runner.node_pair import NodePair, choose_pair, describe_topics
from pid_control.signal_runner.signal_bench import SignalBench

#: Default step of the clock [s]: loops of up to 100 Hz keep their rate.
STEP_S = 0.01
#: First time of the simulated clock [s], for programs that divide by it.
_FIRST_CLOCK = 0.01
#: Timeouts [s]: until both nodes have topics and are connected, and of the optional clock.
_CONNECT_S, _CLOCK_S = 20.0, 1.0
#: Shortest time of the clock after which topics count as missing [s].
_PATIENCE_S = 3.0
#: Time for further topics, once two nodes are connected [s].
_MORE_S = 0.5
#: By a simulated clock, loops that start at the same time would always wake together, and the
#: order of their iterations would be random. So nodes start some time apart [s]. A jump of the
#: clock restarts the first node's loop, whatever its start time [s].
_APART_S, _JUMP_S = 0.03, 1.0
#: Pause between two steps of a wait, and interval of the questions to the nodes [s].
_STEP_PAUSE_S = 0.005
_ASK_S = 0.05
#: Pauses of the clock in which only a loop by the machine's clock publishes.
_PAUSES = 4
#: Length of a pause by the machine's clock, as a multiple of the run before it; at least, and at
#: most [s].
_PAUSE_FACTOR, _SHORTEST_PAUSE_S, _LONGEST_PAUSE_S = 3.0, 0.05, 3.0
#: Messages in one step that only a loop without a pause sends.
_FLOOD = 200


class TrialError(Exception):
    """Error of a node that fails in a trial.

    :ivar flaw: short name
    :ivar node: name of the node; empty if unknown
    :ivar words: last line of its output
    """

    def __init__(self, flaw: str, node: str, words: str = "") -> None:
        super().__init__(f"{node}: {flaw}")
        self.flaw, self.node, self.words = flaw, node, words


class NotConnectedError(Exception):
    """Error of two nodes that are not connected; the text lists the topics of each."""


class Trial:
    """Run of a student's nodes; a context manager that ends them.

    :param bench: the bench
    :param master: the private master
    :param nodes: nodes, started in this order
    :param parameters: parameters to set, by global name
    :param deadline: deadline by the monotonic clock [s]
    :param is_simulated: True for a simulated clock, False for the machine's
    :param group: namespace to start the nodes and their parameters in; empty for none
    :param step: step of the clock [s]
    """

    def __init__(
        self,
        bench: SignalBench,
        master: PrivateMaster,
        nodes: Sequence[StudentNode],
        parameters: Mapping[str, Any],
        deadline: float,
        is_simulated: bool = True,
        group: str = "",
        step: float = STEP_S,
    ) -> None:
        self._step = step
        self._bench, self._master, self._nodes = bench, master, list(nodes)
        grouped = {group + name: value for name, value in parameters.items()}
        self._parameters = {**parameters, **grouped}  # a source may read a global name
        self._deadline, self._is_simulated, self._group = deadline, is_simulated, group
        self._running: Dict[str, ProgramProcess] = {}
        self._restless: Optional[BusyDetector] = None
        self._clock: Clock = WallClock()
        #: Time by the clock, and at its start [s].
        self.now = self._began = _FIRST_CLOCK if is_simulated else time.monotonic()

    def __enter__(self) -> "Trial":
        for name in rospy.get_param_names():
            if name not in ("/rosdistro", "/rosversion", "/run_id", "/use_sim_time"):
                rospy.delete_param(name)
        for name, value in self._parameters.items():
            rospy.set_param(name, value)
        rospy.set_param("/use_sim_time", self._is_simulated)
        self._bench.use_clock(self._is_simulated)
        self._bench.listen({})
        return self

    def __exit__(
        self,
        error_type: Optional[Type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None:
        with deferred_signals():
            for process in self._running.values():
                process.end()

    @property
    def latest(self) -> float:
        """Largest delay of this process with the machine's clock so far [s]."""
        return self._clock.latest if isinstance(self._clock, WallClock) else 0.0

    def own_parameters(self) -> Dict[str, Any]:
        """Return the parameters that the nodes themselves have set, by global name."""
        places = tuple(f"{node.global_name}/" for node in self._nodes)
        names = [name for name in rospy.get_param_names() if name.startswith(places)]
        return {name: rospy.get_param(name) for name in names if name not in self._parameters}

    def start(self) -> None:
        """Start all nodes.

        :raises TrialError: if a node cannot be started
        """
        for node in self._nodes:
            self.start_node(node)
            if self._restless is None:
                watch = self._running[node.global_name].watch  # of the younger ones too
                self._restless = BusyDetector(watch.busy)
                if self._is_simulated:
                    self._clock = SimulatedClock(watch)
                self._clock.start()
                self._wait_for_clock()
                if self._is_simulated:
                    self.now += _JUMP_S
            self.run(_APART_S)

    def start_node(self, node: StudentNode) -> None:
        """Start a node; a simulated clock pauses until the node receives it.

        :raises TrialError: if it cannot be started
        """
        namespace = (self._group + node.namespace).rstrip("/") or "/"
        names = [f"__name:={node.name}", f"__ns:={namespace}"]
        command = node.command._replace(argv=[*node.command.argv, *names])
        try:
            with deferred_signals():
                self._running[node.global_name] = ProgramProcess(
                    command, self._master.environment, [self._master.pid]
                )
        except OSError as error:
            raise TrialError("crash", node.global_name, error.strerror or "") from None
        if self._restless is not None:
            self._wait_for_clock()

    def stop_node(self, node: StudentNode) -> None:
        """End a node as Ctrl-C does, or kill it. Nodes started later end with it."""
        begin, process = time.monotonic(), self._running.pop(node.global_name)
        process.interrupt()
        process.end()
        if not self._is_simulated:  # that clock continues meanwhile
            self.now += time.monotonic() - begin

    def find_pair(self) -> NodePair:
        """Run until one node receives another's topic, and return both.

        :raises TrialError: if a node ends
        :raises NotConnectedError: if no node receives another's topic
        """
        found: Dict[str, NodeTopics] = {}
        changed_at = self.now, time.monotonic()

        def has_topics() -> bool:
            nonlocal changed_at
            before = dict(found)
            for node in self._nodes:
                topics = self._bench.topics_of(self._group + node.global_name)
                if topics is not None:
                    found[node.global_name] = topics
            if found != before:
                changed_at = self.now, time.monotonic()
            return choose_pair(self._nodes, found) is not None or self._is_over(found, *changed_at)

        if self._wait(has_topics):
            published = [one.published.items() for one in found.values()]
            with contextlib.suppress(MessageTypeError):  # to notice a flood
                self._bench.listen(dict(pair for topics in published for pair in topics))
            self.run(_MORE_S)  # topics may appear one by one
            has_topics()
        pair = choose_pair(self._nodes, found)
        if pair is None:
            raise NotConnectedError(describe_topics(self._nodes, found))
        return pair

    def _is_over(
        self, found: Mapping[str, NodeTopics], changed: float, changed_by_machine: float
    ) -> bool:
        """Return True if all nodes have topics, wait, and have added none for long."""
        watch = next(iter(self._running.values())).watch
        return (
            len(found) == len(self._nodes)
            and all(one.published or one.subscribed for one in found.values())
            and min(self.now - changed, time.monotonic() - changed_by_machine) > _PATIENCE_S
            and watch.is_idle()
        )

    def connect(self, pair: NodePair) -> None:
        """Run until the process node receives the generator's topics, and listen to both.

        :param pair: both nodes
        :raises TrialError: if a node ends
        :raises NotConnectedError: if it does not
        """
        self._bench.listen({**pair.inputs, **pair.outputs, **pair.others})
        self.connect_again(pair)

    def connect_again(self, pair: NodePair) -> None:
        """Run until the process node receives the generator's topics.

        :param pair: both nodes
        :raises TrialError: if a node ends
        :raises NotConnectedError: if it does not
        """
        name = self._group + pair.process.global_name
        if not self._wait(lambda: set(pair.inputs) <= self._bench.links_of(name)):
            names = ", ".join(sorted(set(pair.inputs) - self._bench.links_of(name)))
            raise NotConnectedError(f"{pair.process.global_name} does not receive {names}")

    def topics(self, nodes: Sequence[StudentNode]) -> List[str]:
        """Run until nodes publish, and return all their topics.

        :param nodes: the nodes
        :raises TrialError: if a node ends
        """
        names = [self._group + node.global_name for node in nodes]

        def found() -> List[Optional[NodeTopics]]:
            return [self._bench.topics_of(name) for name in names]

        self._wait(lambda: all(one is not None and one.published for one in found()))
        self.run(_MORE_S)
        known = [one for one in found() if one is not None]
        return sorted({topic for one in known for topic in (*one.published, *one.subscribed)})

    def run(self, duration: float) -> None:
        """Run for a time.

        :param duration: time by the clock [s]
        :raises TrialError: if a node fails
        """
        end = self.now + duration
        while self.now < end:
            self.step()

    def step(self) -> None:
        """Advance the clock by one step.

        :raises TrialError: if a node fails
        :raises TimeLimitExceeded: if the deadline has passed
        :raises JudgingError: if the machine is too busy
        """
        if time.monotonic() > self._deadline:
            raise TimeLimitExceeded
        self.now += self._step
        self._bench.set_clock(self.now)
        is_idle = self._clock.wait(self.now - self._began)
        is_flood = self._bench.pop_count() > _FLOOD
        assert self._restless is not None
        self._restless.update(is_idle, is_flood)
        self._check(self._restless.is_its_own())

    def publishes_while_paused(self) -> bool:
        """Pause the clock; return True if the nodes publish on: they use the machine's clock.

        Late messages of a busy machine arrive in one pause; those of a loop arrive in the next
        ones too, each twice as long as the one before.
        """
        for _ in range(_PAUSES):
            pause = self._clock.pause(self.now, self._bench.pop_count)
            if pause is None or pause.answers <= 1:
                return False
        return True

    def run_with_pauses(self, durations: Sequence[float]) -> List[float]:
        """Run several times, with a longer pause of the simulated clock after each.

        :param durations: times to run by the clock [s]
        :returns: times of the pauses by the clock [s]
        :raises TrialError: if a node fails
        :raises TimeLimitExceeded: if the deadline has passed
        :raises JudgingError: if the machine is too busy
        """
        pauses: List[float] = []
        for duration in durations:
            begin = time.monotonic()
            self.run(duration)
            length = _PAUSE_FACTOR * (time.monotonic() - begin)
            time.sleep(min(max(length, _SHORTEST_PAUSE_S), _LONGEST_PAUSE_S))
            pauses.append(self.now)
        self.run(durations[0])  # the pauses are between messages
        return pauses

    def _wait_for_clock(self) -> None:
        """Wait until all nodes have the clock, and are idle; not for long, as it is optional."""
        end, watch = time.monotonic() + _CLOCK_S, next(iter(self._running.values())).watch
        while self._is_simulated and self._bench.clock_listeners() < len(self._running):
            if watch.is_idle() and time.monotonic() > end:
                return
            self._bench.set_clock(self.now)
            time.sleep(STEP_S)
            self._check(False)
        if self._is_simulated:
            watch.wait_idle(_CLOCK_S)

    def run_past(self, topic: str) -> None:
        """Run until a loop that publishes a topic is between two iterations.

        :param topic: the topic; no effect without recent messages
        """
        begin = self.now
        while self.now - begin < _CLOCK_S:
            times = [time for one in self._bench.channels(topic) for time in one.times[-1:]]
            if not times or _APART_S <= self.now - max(times) < 2.0 * _APART_S:
                return
            self.step()

    def _check(self, is_restless: bool) -> None:
        for name, process in self._running.items():
            failure = failure_of(process)
            if failure:
                raise TrialError(failure, name, process.last_words())
        if is_restless:
            raise TrialError("flood", self._busiest())

    def _busiest(self) -> str:
        """Return the name of the node that uses most processor time."""
        before = {name: process.processor_time() for name, process in self._running.items()}
        time.sleep(0.3)
        spent = {
            name: process.processor_time() - before[name] for name, process in self._running.items()
        }
        return max(spent, key=lambda name: spent[name])

    def _wait(self, is_done: Any) -> bool:
        """Run until a condition holds; return False if it does not in time."""
        end = time.monotonic() + _CONNECT_S
        begin, asked = self.now, 0.0
        while True:
            now = time.monotonic()
            if now - asked > _ASK_S:
                if is_done():
                    return True
                asked = time.monotonic()
            first = next(iter(self._running.values()))
            self.step()
            time.sleep(_STEP_PAUSE_S)
            # Only if it has started, on a busy machine.
            if self.now - begin > _PATIENCE_S and now > end:
                if first.watch.is_idle() or first.watch.busy() > _CONNECT_S:
                    return False
