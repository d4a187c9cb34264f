"""Session that judges a controller: runs its scenarios with a simulated or a real plant."""

import os
import time
from typing import List, Mapping, Optional, Protocol, Sequence, Tuple

from pid_control.judging.controller_judgement import is_fatal, judge
from pid_control.judging.evidence import adapted
from pid_control.runner.judging_errors import BusyMachineError, JudgingError, TimeLimitExceeded
from pid_control.verdicts.judgement import Judgement
from pid_control.verdicts.limits import Limits
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, Scenario
from pid_control.programs.program_command import ProgramCommand
from pid_control.programs.package_messages import MessageTypeError
from pid_control.runner.loop_messages import given_message
from pid_control.programs.private_master import PrivateMaster
from pid_control.runner.student_messages import read_messages


class Runner(Protocol):
    """Runner of scenarios.

    :ivar most_late: largest allowed delay of the judge with the machine's clock [s]
    :ivar latest: largest delay so far [s]
    """

    most_late: float
    latest: float

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :raises TimeLimitExceeded: if the deadline has passed
        :raises OSError: if the controller cannot be started
        """


class Session:
    """One judgement of a controller; the time limit starts when the session is created.

    :param command: command of the controller
    :param only: scenarios to run; None for all that the plant supports
    :param limits: limits of the figures
    :param time_limit: time limit [s]
    :param types: ``PACKAGE/TYPE/FIELD`` given for topics, by topic

    :ivar records: records of the scenarios so far
    :ivar notes: notes on the types of the controller's messages
    """

    def __init__(
        self,
        command: ProgramCommand,
        only: Optional[Sequence[Scenario]],
        limits: Limits,
        time_limit: float,
        types: Optional[Mapping[str, str]] = None,
    ) -> None:
        self._types, self.notes = types or {}, list(command.notes)
        self._command, self._only, self._limits = command, only, limits
        self._time_limit, self._deadline = time_limit, time.monotonic() + time_limit
        self.records: List[Record] = []

    def judge_with_own_plant(self, real_time: bool) -> Judgement:
        """Judge with a simulated plant on a private master.

        :param real_time: True for the machine's clock, False for a simulated one
        :raises JudgingError: if the controller cannot be judged
        """
        master = PrivateMaster()
        try:
            # Imported late: rospy reads the master's address when it is imported.
            from pid_control.runner.bench_runner import BenchRunner
            from pid_control.runner.test_bench import PublisherConflict, TestBench

            found = read_messages(self._command, os.path.join(master.folder, "messages"))
            given = {
                topic: given_message(topic, text, found.classes)
                for topic, text in self._types.items()
            }
            self.notes = list(found.command.notes)
            bench = TestBench({**found.by_topic, **given})
            runner = BenchRunner(
                bench,
                found.command,
                master.environment,
                real_time,
                self._deadline,
                master.pid,
                found.classes,
            )
            try:
                reason = self._run(runner, self._only or list(BY_NAME.values()))
            except PublisherConflict as error:
                raise JudgingError(str(error)) from None
            self.notes += runner.notes
            if not master.is_running():
                raise JudgingError("the judge's own master ended; is this machine out of memory?")
            bench.close()
        except MessageTypeError as error:
            raise JudgingError(str(error)) from None
        finally:
            master.close()
        return judge(self.records, self._limits, reason)

    def judge_with_real_plant(self, full_speed: float) -> Judgement:
        """Judge with the real plant on the current master.

        :param full_speed: greatest speed of the plant [rad/s]
        :raises JudgingError: if the controller cannot be judged
        """
        from pid_control.runner.real_plant import PlantError, RealPlant
        from pid_control.runner.real_plant_runner import RealPlantRunner

        wanted, left_out = self._for_real_plant()
        if self._command.parameters.get("/use_sim_time"):
            what = "it sets /use_sim_time, which would also affect the plant; remove that"
            raise JudgingError(f"{self._command.name}: {what}")
        try:
            plant = RealPlant()
            try:
                runner = RealPlantRunner(plant, self._command, full_speed, self._deadline)
                reason = self._run(runner, wanted)
            finally:
                plant.close()
        except PlantError as error:
            raise JudgingError(str(error)) from None
        return judge(self.records, self._limits, reason)._replace(left_out=left_out)

    def _for_real_plant(self) -> Tuple[Sequence[Scenario], List[str]]:
        """Return the scenarios to run, and the names of scenarios unsuitable for a real plant."""
        possible = [one for one in BY_NAME.values() if one.suits_any_plant]
        for scenario in self._only or ():
            if scenario not in possible:
                names = ", ".join(one.name for one in possible)
                raise JudgingError(f"{scenario.name} is not for a real plant: there are {names}")
        return self._only or possible, [name for name in BY_NAME if BY_NAME[name] not in possible]

    def _run(self, runner: Runner, scenarios: Sequence[Scenario]) -> str:
        """Run the scenarios; return why some were not run, or an empty text."""
        reason = ""
        for scenario in scenarios:
            try:
                self.records.append(runner.run(adapted(scenario, self.records)))
            except TimeLimitExceeded:
                reason = f"{self._time_limit:g} s are over in {scenario.name}"
                break
            except OSError as error:
                raise JudgingError(f"{self._command.name}: {error.strerror}") from None
            if is_fatal(self.records[-1], self._limits):
                break
        if runner.latest > runner.most_late:
            raise BusyMachineError(
                f"this machine is too busy: the judge itself was {runner.latest:.3f} s late"
            )
        return reason
