"""One judgement: a controller, its scenarios, and a plant of the judge's own or a real one."""

import time
from typing import List, Optional, Sequence, Tuple

from pid_control.judging.judgement import Judgement, is_fatal, judge
from pid_control.judging.limits import Limits
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, Scenario
from pid_control.trial.outcome import CannotJudge, OutOfTime, Runner
from pid_control.trial.own_master import OwnMaster
from pid_control.trial.target import Target


class Session:
    """Judges a controller once; the time runs from when this is made.

    :param target: the controller
    :param only: the scenarios that are wanted; None for all that can be
    :param limits: what it has to keep
    :param time_limit: how long it may take, s

    :ivar records: what came of the scenarios so far
    """

    def __init__(
        self,
        target: Target,
        only: Optional[Sequence[Scenario]],
        limits: Limits,
        time_limit: float,
    ) -> None:
        self._target, self._only, self._limits = target, only, limits
        self._time_limit, self._deadline = time_limit, time.monotonic() + time_limit
        self.records: List[Record] = []

    def judge_with_own_plant(self, real_time: bool) -> Judgement:
        """Judge on a master of its own.

        :param real_time: whether to go by the machine's clock
        :raises CannotJudge: if that cannot be
        """
        master = OwnMaster()
        try:
            # They import rospy, which goes by the master that it finds.
            from pid_control.trial.stage import Rivals, Stage
            from pid_control.trial.trial import Trial

            stage = Stage()
            environment = master.environment
            trial = Trial(stage, self._target, environment, real_time, self._deadline)
            try:
                reason = self._run(trial, self._only or list(BY_NAME.values()))
            except Rivals as error:
                raise CannotJudge(str(error)) from None
            stage.close()
        finally:
            master.close()
        return judge(self.records, self._limits, reason)

    def judge_with_real_plant(self, full_speed: float) -> Judgement:
        """Judge on the master that is there, with the plant that is there.

        :param full_speed: its greatest speed, rad/s
        :raises CannotJudge: if that cannot be
        """
        from pid_control.trial.real_plant import RealPlant, Unsuitable
        from pid_control.trial.real_trial import RealTrial

        wanted, left_out = self._for_real_plant()
        if self._target.parameters.get("/use_sim_time"):
            what = "it sets /use_sim_time, by which the plant would go too: leave that out"
            raise CannotJudge(f"{self._target.name}: {what}")
        try:
            plant = RealPlant()
            try:
                trial = RealTrial(plant, self._target, full_speed, self._deadline)
                reason = self._run(trial, wanted)
            finally:
                plant.close()
        except Unsuitable as error:
            raise CannotJudge(str(error)) from None
        return judge(self.records, self._limits, reason)._replace(left_out=left_out)

    def _for_real_plant(self) -> Tuple[Sequence[Scenario], List[str]]:
        """Return the scenarios to run, and the names of those that cannot be."""
        possible = [one for one in BY_NAME.values() if one.suits_any_plant]
        for scenario in self._only or ():
            if scenario not in possible:
                names = ", ".join(one.name for one in possible)
                raise CannotJudge(f"{scenario.name} is not for a real plant: there are {names}")
        return self._only or possible, [name for name in BY_NAME if BY_NAME[name] not in possible]

    def _run(self, runner: Runner, scenarios: Sequence[Scenario]) -> str:
        """Run the scenarios, and return why not all of them, if so."""
        reason = ""
        for scenario in scenarios:
            try:
                self.records.append(runner.run(scenario))
            except OutOfTime:
                reason = f"{self._time_limit:g} s are over in {scenario.name}"
                break
            except OSError as error:
                raise CannotJudge(f"{self._target.name}: {error.strerror}") from None
            if is_fatal(self.records[-1], self._limits):
                break
        if runner.latest > runner.most_late:
            raise CannotJudge(
                f"this machine is too busy: the judge itself was {runner.latest:.3f} s late"
            )
        return reason
