"""Runner of a controller process in scenarios with a simulated motor, set point and clock."""

import contextlib
import math
import time
from typing import Any, Dict, List, Optional, Tuple

import rospy

from pid_control.judging.experiment import Experiment, MotorOutput, OutgoingMessages
from pid_control.judging.record import ENDED, NOT_CONNECTED, Pause, Record
from pid_control.judging.scenarios import STEP_S, Scenario
from pid_control.plant.status import NOT_TURNING
from pid_control.runner.clock import Clock, SimulatedClock, WallClock
from pid_control.programs.program_command import ProgramCommand
from pid_control.programs.program_process import ProgramProcess
from pid_control.programs.deferred_signals import deferred_signals
from pid_control.programs.package_messages import MessageTypeError, class_of
from pid_control.runner.judging_errors import TimeLimitExceeded
from pid_control.runner.loop_messages import loop_message
from pid_control.runner.failure_detection import BusyDetector, completed, failure_of
from pid_control.runner.student_messages import describe
from pid_control.runner.test_bench import TestBench

#: Time of the clock when a controller starts [s]. A controller that reads the time before the first
#: clock message gets 0; its first interval must not be long.
_FIRST_CLOCK = 0.01
#: Timeouts [s]: for the controller's first connection, from then on for all of its connections, and
#: for the connections of the previous controller to close.
_FIRST_TOPIC_S, _ALL_TOPICS_S, _GONE_S = 20.0, 5.0, 5.0
#: Time for a connected controller to subscribe to the clock [s], which is optional.
_CLOCK_S = 1.0
#: Answers to one step that only a loop without a pause sends.
_FLOOD = 100
#: Longest time of the clock until the first answer of a controller that a motor awaits [s].
_FIRST_ANSWER_S = 10.0
#: Longest wait for an idle controller before each step until it answers [s].
_IDLE_S = 0.1
#: Time of the closed loop before a scenario begins [s].
_SETTLE_S = 0.1


class BenchRunner:
    """Runner with a :class:`.TestBench`; each scenario has its own controller process.

    :param bench: the test bench
    :param command: command of the controller
    :param environment: additional environment variables of the controller
    :param real_time: True for the machine's clock, False for a simulated one
    :param deadline: deadline of all scenarios by the monotonic clock [s]
    :param master: process of the bench's master
    :param classes: message classes of the controller's package by type

    :ivar notes: notes on types that the bench has adopted from the controller
    """

    #: Largest delay of this process with the machine's clock [s]: it simulates the motor.
    most_late = 0.02

    def __init__(
        self,
        bench: TestBench,
        command: ProgramCommand,
        environment: Dict[str, str],
        real_time: bool,
        deadline: float,
        master: int,
        classes: Optional[Dict[str, Any]] = None,
    ) -> None:
        self._master, self._classes = master, classes or {}
        self.notes: List[str] = []
        self._bench, self._command, self._environment = bench, command, environment
        self._real_time, self._deadline = real_time, deadline
        #: Longest time of the clock until a first answer, so far [s].
        self._first_answer_s = 0.0
        #: Time of the simulated clock [s].
        self._clock = _FIRST_CLOCK
        #: Largest delay of this process so far, with the machine's clock [s].
        self.latest = 0.0
        for key, value in {**command.of_others, **command.parameters}.items():
            rospy.set_param(key, value)
        rospy.set_param("/use_sim_time", not real_time)

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :raises TimeLimitExceeded: if the deadline has passed
        :raises PublisherConflict: if another node publishes the bench's topics
        :raises OSError: if the controller cannot be started
        """
        record = self._start_and_run(scenario)
        if record is None:  # the bench has the controller's types now
            record = self._start_and_run(scenario)
            assert record is not None
        return record

    def _start_and_run(self, scenario: Scenario) -> Optional[Record]:
        """Run one scenario; return None if it must be run again, with other types."""
        self._wait_until_alone()
        self._clock = _FIRST_CLOCK
        controller: Optional[ProgramProcess] = None
        try:
            with deferred_signals():
                controller = ProgramProcess(self._command, self._environment, [self._master])
            return self._run(scenario, controller)
        finally:
            if controller is not None:
                controller.end()

    def _follow_types(self) -> bool:
        """Adopt the controller's types of topics that are not connected; return False without any.

        Only once: types that the user has given are not replaced.
        """
        if self.notes:
            return False
        types, messages = self._bench.types_of_controller(), dict(self._bench.messages)
        for topic, message in messages.items():
            msg_type = types.get("/" + topic, message.message_class._type)
            if msg_type != message.message_class._type:
                with contextlib.suppress(MessageTypeError):
                    messages[topic] = loop_message(topic, class_of(topic, msg_type, self._classes))
                    self.notes.append(describe(messages[topic]))
        if self.notes:
            self._bench.follow(messages)
        return bool(self.notes)

    def _run(self, scenario: Scenario, controller: ProgramProcess) -> Optional[Record]:
        experiment = Experiment(scenario, self._clock)
        if not self._connect(experiment, controller):
            failure = ENDED if controller.status is not None else NOT_CONNECTED
            if failure == NOT_CONNECTED and self._follow_types():
                return None
            missing, hint = self._bench.missing(), self._bench.hint()
            words = controller.last_words()
            is_simulated = not self._real_time
            return Record(scenario, failure, words, missing, hint, is_simulated=is_simulated)
        self._bench.check_publishers()
        watch = controller.watch
        clock: Clock = WallClock()
        if not self._real_time:
            clock = SimulatedClock(watch)
        began, zero = self._clock, self._clock + _SETTLE_S
        experiment.begin_at(zero)
        self._bench.pop_inputs()  # drop inputs from before the scenario
        answers: List[Tuple[float, float]] = []
        pauses: List[Pause] = []
        failure, busy_before = "", watch.busy()
        restless = BusyDetector(watch.busy)
        clock.start()
        while self._clock < zero + scenario.duration and not failure:
            self._check_time()
            now = self._clock
            self._bench.send(experiment.send(now), now)
            self._clock += experiment.step_after(now)
            is_idle, inputs = clock.wait(self._clock - began), self._bench.pop_inputs()
            restless.update(is_idle, len(inputs) >= _FLOOD)
            for value in inputs:
                answers.append((experiment.time_at(now), value))
                experiment.answer(now, value)
            if any(now < zero + at <= self._clock for at in scenario.pauses):
                pause = clock.pause(experiment.time_at(now), lambda: len(self._bench.pop_inputs()))
                pauses += [] if pause is None else [pause]
            failure = failure_of(controller, restless.is_its_own())
        if isinstance(clock, WallClock):
            self.latest = max(self.latest, clock.latest)
        record = Record(
            scenario,
            failure,
            rows=experiment.rows,
            answers=answers,
            busy=watch.busy() - busy_before,
            is_simulated=not self._real_time,
            pauses=pauses,
        )
        return completed(record, controller)

    def _connect(self, experiment: Experiment, controller: ProgramProcess) -> bool:
        """Advance the time until the controller answers; return False if it does not connect."""
        watch = controller.watch
        end, clock_end, answer_end = time.monotonic() + _FIRST_TOPIC_S, math.inf, math.inf
        is_alone = True
        while True:
            self._check_time()
            now = time.monotonic()
            if is_alone and self._bench.is_connected():
                end, is_alone = now + _ALL_TOPICS_S, False
            if not self._bench.missing():
                clock_end = min(clock_end, now + _CLOCK_S)
                if self._real_time or self._bench.has_clock_listener() or now > clock_end:
                    answer_end = min(answer_end, self._clock + self._patience(experiment))
                    if self._bench.pop_inputs():
                        self._first_answer_s = max(self._first_answer_s, self._clock)
                        return True
                    if self._clock >= answer_end:
                        return True
            if controller.status is not None:
                return False
            if (
                self._bench.missing()
                and now > end
                and (watch.is_idle() or watch.busy() > _FIRST_TOPIC_S)
            ):
                return False  # only if it has started, on a busy machine
            self._bench.send(experiment.send(self._clock), self._clock)
            if self._bench.has_clock_listener() or answer_end < math.inf:
                self._clock += STEP_S
            if self._real_time or answer_end == math.inf or not watch.wait_idle(_IDLE_S):
                time.sleep(STEP_S)

    def _patience(self, experiment: Experiment) -> float:
        """Return the longest time of the clock until the first answer [s].

        A controller may answer only a motor: without a motor, the limit is its earlier time.
        """
        return _FIRST_ANSWER_S if experiment.has_motor else self._first_answer_s

    def _wait_until_alone(self) -> None:
        """Wait until the connections of ended controllers are closed."""
        end = time.monotonic() + _GONE_S
        nothing = OutgoingMessages(0.0, MotorOutput(0.0, 0.0, NOT_TURNING))
        while self._bench.is_connected() and time.monotonic() < end:
            self._bench.send(nothing, self._clock)  # only a write detects a dead connection
            time.sleep(STEP_S)

    def _check_time(self) -> None:
        if time.monotonic() > self._deadline:
            raise TimeLimitExceeded
