"""Control laws for tests: factories of laws with state, and random correct laws."""

from typing import Any, Callable, Dict, List

from hypothesis import strategies as some

from pid_control.controller.pid import BACK_CALCULATION, CLAMPING, PI, PID, PidSettings
from pid_control.judging.experiment import MotorOutput
from pid_control.judging.simulation import Law, pid_law

#: Returns the input: state, set point, speed, time since the previous turn.
Step = Callable[[Dict[str, float], float, float, float], float]


def clipped(value: float, limit: float = 1.0) -> float:
    return max(-limit, min(limit, value))


def law_of(step: Step) -> Callable[[], Law]:
    """Return a factory of a control law with its own state."""

    def make() -> Law:
        state: Dict[str, float] = {"integral": 0.0, "before": 0.0, "input": 0.0}
        times: List[float] = []

        def answer(set_point: float, output: MotorOutput) -> float:
            dt = output.time - times[-1] if times and output.time > times[-1] else 0.0
            times.append(output.time)
            return step(state, set_point, output.speed, dt)

        return answer

    return make


#: Arguments of :func:`correct`, and the period of the loop [s]: gains from too small to too large.
CORRECT: Dict[str, Any] = dict(
    kp=some.floats(-2.5, 0.5).map(lambda power: 10.0**power),
    ki=some.floats(-0.5, 2.0).map(lambda power: 10.0**power),
    kd=some.one_of(some.just(0.0), some.floats(1e-4, 1e-2)),
    filter_time=some.sampled_from([0.005, 0.01, 0.02]),
    limit=some.sampled_from([0.8, 0.9, 1.0]),
    anti_windup=some.sampled_from([CLAMPING, BACK_CALCULATION, "bounded", "velocity"]),
    period=some.sampled_from([0.0, 0.005, 0.01, 0.02]),
)


def correct(
    kp: float, ki: float, kd: float, filter_time: float, limit: float, anti_windup: str
) -> Callable[[], Law]:
    """Return a controller without a fault; its gains need not suit."""
    if anti_windup in (CLAMPING, BACK_CALCULATION):
        own = PidSettings(
            mode=PID if kd else PI,
            kp=kp,
            ki=ki,
            kd=kd,
            filter_time=filter_time,
            output_min=-limit,
            output_max=limit,
            anti_windup=anti_windup,
            tracking_time=0.05,
        )
        return lambda: pid_law(own)

    def bounded(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
        error = set_point - speed
        state["integral"] = clipped(state["integral"] + error * dt, limit / ki)
        return clipped(kp * error + ki * state["integral"], limit)

    def velocity(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
        error = set_point - speed
        change = kp * (error - state["before"]) + ki * error * dt
        state["input"], state["before"] = clipped(state["input"] + change, limit), error
        return state["input"]

    return law_of(bounded if anti_windup == "bounded" else velocity)
