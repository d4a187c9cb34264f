"""What the judge says of the reference controller with gains."""

import os
import time
from typing import Iterator, Sequence, Tuple

import rospkg

from pid_control.judging.judgement import judge
from pid_control.judging.limits import read_limits
from pid_control.judging.reports import as_sentences
from pid_control.judging.scenarios import BY_NAME
from pid_control.trial.own_master import OwnMaster
from pid_control.trial.target import find_target
from pid_control.tuning.rules import Gains

#: How long the judgement of one may take, s.
_TIME_LIMIT_S = 120.0


def judge_gains(several: Sequence[Gains]) -> Iterator[Tuple[Gains, str]]:
    """Judge the reference controller with gains, one after the other, with the course's motor.

    :param several: the gains
    :returns: each with what is wrong, and the verdict
    :raises OutOfTime: if a judgement takes too long
    """
    folder = rospkg.RosPack().get_path("pid_control")
    with open(os.path.join(folder, "config", "judge_limits.yaml"), encoding="utf-8") as file:
        limits = read_limits(file.read())
    master = OwnMaster()
    try:
        # They import rospy, which goes by the master that it finds.
        from pid_control.trial.stage import Stage
        from pid_control.trial.trial import Trial

        stage = Stage()
        for gains in several:
            values = gains._asdict()
            words = [f"_{name}:={values[name]}" for name in ("mode", "kp", "ki", "kd")]
            words.append(f"_filter_time:={gains.filter_time}")
            target = find_target(["pid_control", "controller.py", *words])
            deadline = time.monotonic() + _TIME_LIMIT_S
            trial = Trial(stage, target, master.environment, False, deadline)
            records = [trial.run(scenario) for scenario in BY_NAME.values()]
            yield gains, as_sentences(judge(records, limits, ""))
    finally:
        master.close()
