"""What the judge says of the reference controller with gains."""

import time
from typing import Iterator, List, Sequence, Tuple

from pid_control.judging.judgement import judge
from pid_control.judging.record import Record
from pid_control.judging.reports import as_sentences
from pid_control.judging.scenarios import SCENARIOS, Scenario
from pid_control.runner.controller_command import find_controller
from pid_control.runner.default_limits import default_limits
from pid_control.runner.outcome import TimeLimitExceeded
from pid_control.runner.private_master import PrivateMaster
from pid_control.tuning.rules import Gains

#: How long the judgement of one may take, s.
TIME_LIMIT_S = 120.0


def judge_gains(
    several: Sequence[Gains],
    scenarios: Sequence[Scenario] = SCENARIOS,
    time_limit: float = TIME_LIMIT_S,
) -> Iterator[Tuple[Gains, str]]:
    """Judge the reference controller with gains, one after the other, with the course's motor.

    :param several: the gains
    :param scenarios: what they have to go through
    :param time_limit: how long the judgement of one may take, s
    :returns: each with what is wrong, and the verdict
    """
    limits = default_limits()
    master = PrivateMaster()
    try:
        # They import rospy, which goes by the master that it finds.
        from pid_control.runner.bench_runner import BenchRunner
        from pid_control.runner.test_bench import TestBench

        bench = TestBench()
        for gains in several:
            values = gains._asdict()
            words = [f"_{name}:={values[name]}" for name in ("mode", "kp", "ki", "kd")]
            words.append(f"_filter_time:={gains.filter_time}")
            command = find_controller(["pid_control", "controller.py", *words])
            deadline = time.monotonic() + time_limit
            runner = BenchRunner(bench, command, master.environment, False, deadline)
            records: List[Record] = []
            reason = ""
            try:
                for scenario in scenarios:
                    records.append(runner.run(scenario))
            except TimeLimitExceeded:
                reason = f"{time_limit:g} s are over"
            yield gains, as_sentences(judge(records, limits, reason))
    finally:
        master.close()
