"""Test of this package's controller node with given gains and the simulated motor."""

import time
from typing import Iterator, List, Sequence, Tuple

from pid_control.judging.controller_judgement import judge
from pid_control.judging.evidence import adapted
from pid_control.judging.record import Record
from pid_control.runner.judging_errors import TimeLimitExceeded
from pid_control.verdicts.reports import as_sentences
from pid_control.judging.scenarios import SCENARIOS, Scenario
from pid_control.programs.program_command import find_controller
from pid_control.runner.default_limits import default_limits
from pid_control.programs.private_master import PrivateMaster
from pid_control.tuning.rules import Gains

#: Default time limit per set of gains [s].
TIME_LIMIT_S = 120.0
#: Parameters of the controller that are set.
_PARAMETERS = ("mode", "kp", "ki", "kd", "filter_time", "output_min", "output_max")


def judge_gains(
    several: Sequence[Gains],
    scenarios: Sequence[Scenario] = SCENARIOS,
    time_limit: float = TIME_LIMIT_S,
    least: float = -1.0,
    largest: float = 1.0,
) -> Iterator[Tuple[Gains, str]]:
    """Judge the reference controller with each set of gains, with the course's motor.

    :param several: the sets of gains
    :param scenarios: scenarios to run
    :param time_limit: time limit per set of gains [s]
    :param least: lower limit of the controller's output
    :param largest: upper limit of the controller's output
    :returns: each set of gains and the text of its judgement
    """
    limits = default_limits()
    master = PrivateMaster()
    try:
        # Imported late: rospy reads the master's address when it is imported.
        from pid_control.runner.bench_runner import BenchRunner
        from pid_control.runner.test_bench import TestBench

        bench = TestBench()
        for gains in several:
            values = {**gains._asdict(), "output_min": least, "output_max": largest}
            words = [f"_{name}:={values[name]}" for name in _PARAMETERS]
            command = find_controller(["pid_control", "controller.py", *words])
            deadline = time.monotonic() + time_limit
            runner = BenchRunner(bench, command, master.environment, False, deadline, master.pid)
            records: List[Record] = []
            reason = ""
            try:
                for scenario in scenarios:
                    records.append(runner.run(adapted(scenario, records)))
            except TimeLimitExceeded:
                reason = f"{time_limit:g} s are over"
            yield gains, as_sentences(judge(records, limits, reason))
    finally:
        master.close()
