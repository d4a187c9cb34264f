"""Runner of a controller process in scenarios with a real motor on the current ROS master."""

import time
from typing import Dict, List, Optional

import rospy
from rosgraph import get_master_uri

from pid_control.judging.plant_log import answers_of, rows_of
from pid_control.judging.record import ENDED, NOT_CONNECTED, Record
from pid_control.judging.scenarios import MOTOR, SET_POINT_S, Scenario, value_at
from pid_control.runner.clock import WallClock
from pid_control.programs.program_command import ProgramCommand
from pid_control.programs.program_process import ProgramProcess
from pid_control.programs.deferred_signals import deferred_signals
from pid_control.runner.failure_detection import completed, failure_of
from pid_control.runner.judging_errors import JudgingError, TimeLimitExceeded
from pid_control.runner.real_plant import RealPlant

#: Timeout for the controller's connections [s].
_CONNECT_S = 20.0
#: Time of the closed loop before a scenario begins [s].
_SETTLE_S = 0.5


class RealPlantRunner:
    """Runner with a real plant; each scenario has its own controller process.

    However a scenario ends, the controller ends before the plant gets its last input, 0.

    :param plant: the plant
    :param command: command of the controller
    :param full_speed: greatest speed of the plant [rad/s]
    :param deadline: deadline of all scenarios by the monotonic clock [s]
    """

    #: Largest delay of the judge [s]: it only sends set points.
    most_late = 0.1

    def __init__(
        self, plant: RealPlant, command: ProgramCommand, full_speed: float, deadline: float
    ) -> None:
        self._plant, self._command, self._deadline = plant, command, deadline
        self._scale = full_speed / MOTOR.max_output
        #: Largest delay so far [s].
        self.latest = 0.0
        self._controller: Optional[ProgramProcess] = None
        plant.on_shutdown(self._end_controller)
        for key, value in command.parameters.items():  # not the plant's own parameters
            rospy.set_param(key, value)

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :param scenario: a scenario that suits any plant
        :raises TimeLimitExceeded: if the deadline has passed
        :raises PlantError: if the plant becomes silent, is not at rest first, or the node is shut
            down
        :raises OSError: if the controller cannot be started
        """
        self._plant.wait_until_it_stands()
        before = self._plant.connections()
        environment = {"ROS_MASTER_URI": get_master_uri()}
        controller: Optional[ProgramProcess] = None
        try:
            with deferred_signals():
                controller = self._controller = ProgramProcess(self._command, environment)
            record = self._connect_and_run(scenario, controller, before)
            self._plant.check_node()  # a shutdown ends the controller: not a failure
            return record
        finally:
            try:
                self._plant.stop()
                if controller is not None:
                    controller.interrupt()
            finally:
                with deferred_signals():
                    self._end_controller()
                    self._plant.stop()

    def _end_controller(self) -> None:
        if self._controller is not None:
            self._controller.end()

    def _connect_and_run(
        self, scenario: Scenario, controller: ProgramProcess, before: Dict[str, int]
    ) -> Record:
        missing = self._connect(controller, before)
        if missing:
            failure = ENDED if controller.status is not None else NOT_CONNECTED
            return Record(scenario, failure, controller.last_words(), missing)
        self._plant.check_alone()
        return self._run(scenario, controller)

    def _connect(self, controller: ProgramProcess, before: Dict[str, int]) -> List[str]:
        """Wait until the controller is connected; return the topics that are not.

        :param before: number of connections of each topic before the controller started
        """
        end = time.monotonic() + _CONNECT_S
        while True:
            self._check_time()
            self._plant.send_set_point(0.0)
            now = self._plant.connections()
            missing = [name for name, count in now.items() if count <= before[name]]
            if not missing or controller.status is not None or time.monotonic() > end:
                return missing
            time.sleep(SET_POINT_S)

    def _run(self, scenario: Scenario, controller: ProgramProcess) -> Record:
        clock, failure, now = WallClock(), "", -_SETTLE_S
        busy_before = controller.watch.busy()
        self._plant.pop_log()  # drop messages from before the scenario
        zero = time.monotonic() + _SETTLE_S
        clock.start()
        while now < scenario.duration and not failure:
            self._check_time()
            self._plant.send_set_point(self._scale * value_at(scenario.set_point, now))
            now += SET_POINT_S
            clock.wait(now + _SETTLE_S)
            try:
                failure = failure_of(controller)
            except JudgingError:
                self._plant.check_node()  # a node that is shut down has ended the controller
                raise
        self.latest = max(self.latest, clock.latest)
        log = self._plant.pop_log()
        rows = rows_of(log, scenario, zero, self._scale)
        busy = controller.watch.busy() - busy_before
        record = Record(scenario, failure, rows=rows, answers=answers_of(log, zero), busy=busy)
        return completed(record, controller)

    def _check_time(self) -> None:
        if time.monotonic() > self._deadline:
            raise TimeLimitExceeded
