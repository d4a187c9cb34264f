"""Runs of scenarios without ROS: a controller answers each output, or every few outputs."""

from typing import Callable, Dict, List

from pid_control.controller.pid import PI, PidSettings
from pid_control.judging.evidence import adapted
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.verdicts.limits import Limits, read_limits
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, SCENARIOS, Scenario
from pid_control.judging.simulation import Law, pid_law, simulate


def pi(kp: float = 0.08, ki: float = 1.5, **settings: float) -> Callable[[], Law]:
    """Return what makes a law: our own controller's, with dt from the outputs' times."""
    return lambda: pid_law(PidSettings(mode=PI, kp=kp, ki=ki)._replace(**settings))


def play(scenario: Scenario, law: Law) -> Record:
    """Run a scenario with a law that ignores NaN."""
    return simulate(scenario, law)


def play_all(make: Callable[[], Law], period: float = 0.0) -> List[Record]:
    """Run all scenarios, each with a new law, as the judge does."""
    records: List[Record] = []
    for scenario in SCENARIOS:
        records.append(simulate(adapted(scenario, records), make(), period))
    return records


def play_one(name: str, make: Callable[[], Law]) -> Record:
    """Run one scenario."""
    return play(BY_NAME[name], make())


def default_limits() -> Limits:
    """Return the limits that the package brings."""
    import pathlib

    place = pathlib.Path(__file__).resolve().parents[2] / "config" / "judge_limits.yaml"
    return read_limits(place.read_text("utf-8"), SCENARIO_METRICS)


def only(limits: Dict[str, float], scenario: str) -> Limits:
    """Return limits for one scenario."""
    return {scenario: dict(limits)}
