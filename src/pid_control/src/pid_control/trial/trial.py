"""Runs a controller through a scenario."""

import math
import time
from typing import Dict, List, Optional, Tuple

import rospy

from pid_control.judging.experiment import Experiment, Outgoing, Output
from pid_control.judging.record import ENDED, NOT_CONNECTED, Record
from pid_control.judging.scenarios import STEP_S, Scenario
from pid_control.motor.status import NOT_TURNING
from pid_control.trial.controller_process import ControllerProcess
from pid_control.trial.interrupts import interrupts_put_off
from pid_control.trial.outcome import OutOfTime, completed, fate_of
from pid_control.trial.pace import Pace, RealPace, SteppedPace
from pid_control.trial.stage import Stage
from pid_control.trial.target import Target

#: What a clock says as a controller is started, s. A controller that takes the time before the
#: clock is there finds 0, and is not to take all that there was before for one long turn.
_FIRST_CLOCK = 0.01
#: How long a controller may take to find its first topic, s, how long from then on for all, and how
#: long the connections of the one before may take to be gone.
_FIRST_TOPIC_S, _ALL_TOPICS_S, _GONE_S = 20.0, 5.0, 5.0
#: How long a controller that has found all others may take to find the clock, s: it need not.
_CLOCK_S = 1.0
#: How long the loop is closed before a scenario begins, s.
_SETTLE_S = 0.1


class Trial:
    """Runs a controller through scenarios, each with a process of its own.

    :param stage: the graph
    :param target: the controller
    :param environment: variables for it
    :param real_time: whether the machine's clock is gone by, not a simulated one
    :param deadline: when all must be over, by the monotonic clock, s
    """

    #: How late the judge may be where it goes by the machine's clock, s: it is the motor.
    most_late = 0.02

    def __init__(
        self,
        stage: Stage,
        target: Target,
        environment: Dict[str, str],
        real_time: bool,
        deadline: float,
    ) -> None:
        self._stage, self._target, self._environment = stage, target, environment
        self._real_time, self._deadline = real_time, deadline
        #: What the simulated clock says, s.
        self._clock = _FIRST_CLOCK
        #: How late this process was at most where the machine's clock is gone by, s.
        self.latest = 0.0
        for key, value in {**target.of_others, **target.parameters}.items():
            rospy.set_param(key, value)
        rospy.set_param("/use_sim_time", not real_time)

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :raises OutOfTime: if all takes too long
        :raises Rivals: if the controller brings what is here already
        :raises OSError: if the controller cannot be started
        """
        self._wait_until_alone()
        self._clock = _FIRST_CLOCK
        controller: Optional[ControllerProcess] = None
        try:
            with interrupts_put_off():
                controller = ControllerProcess(self._target, self._environment)
            return self._run(scenario, controller)
        finally:
            if controller is not None:
                controller.end()

    def _run(self, scenario: Scenario, controller: ControllerProcess) -> Record:
        experiment = Experiment(scenario, self._clock)
        if not self._connect(experiment, controller):
            fate = ENDED if controller.status is not None else NOT_CONNECTED
            missing, hint = self._stage.missing(), self._stage.hint()
            return Record(scenario, fate, controller.last_words(), missing, hint)
        self._stage.check_rivals()
        watch = controller.watch
        pace: Pace = RealPace()
        if not self._real_time:
            pace = SteppedPace(watch)
        began, zero = self._clock, self._clock + _SETTLE_S
        experiment.begin_at(zero)
        self._stage.heard()  # what came before is not of this scenario
        answers: List[Tuple[float, float]] = []
        standstill: Tuple[int, Optional[float]] = (0, None)
        fate, restless, busy_before = "", 0, watch.busy()
        pace.start()
        while self._clock < zero + scenario.duration and not fate:
            self._check_time()
            now = self._clock
            self._stage.send(experiment.send(now), now)
            self._clock += experiment.step_after(now)
            restless = 0 if pace.wait(self._clock - began) else restless + 1
            for value in self._stage.heard():
                answers.append((now - zero, value))
                experiment.answer(now, value)
            if now < zero + scenario.standstill_at <= self._clock:
                rest = pace.stand_still()
                standstill = len(self._stage.heard()), rest
            fate = fate_of(controller, restless)
        if isinstance(pace, RealPace):
            self.latest = max(self.latest, pace.latest)
        record = Record(
            scenario,
            fate,
            rows=experiment.rows,
            answers=answers,
            busy=watch.busy() - busy_before,
            standstill_answers=standstill[0],
            standstill_rest=standstill[1],
        )
        return completed(record, controller)

    def _connect(self, experiment: Experiment, controller: ControllerProcess) -> bool:
        """Let time pass until the controller has found its topics; tell whether it has."""
        end, clock_end = time.monotonic() + _FIRST_TOPIC_S, math.inf
        is_alone = True
        while self._stage.missing() or not self._stage.has_clock_listener():
            self._check_time()
            now = time.monotonic()
            if is_alone and self._stage.is_connected():
                end, is_alone = now + _ALL_TOPICS_S, False
            if not self._stage.missing():
                clock_end = min(clock_end, now + _CLOCK_S)
                if self._real_time or now > clock_end:
                    return True
            if controller.status is not None or now > end:
                return False
            self._stage.send(experiment.send(self._clock), self._clock)
            if self._stage.has_clock_listener():
                self._clock += STEP_S
            time.sleep(STEP_S)
        return True

    def _wait_until_alone(self) -> None:
        """Wait until nobody is connected any more of those that have ended."""
        end = time.monotonic() + _GONE_S
        nothing = Outgoing(0.0, Output(0.0, 0.0, NOT_TURNING))
        while self._stage.is_connected() and time.monotonic() < end:
            self._stage.send(nothing, self._clock)  # a dead connection is noticed by writing to it
            time.sleep(STEP_S)

    def _check_time(self) -> None:
        if time.monotonic() > self._deadline:
            raise OutOfTime
