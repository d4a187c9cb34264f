"""Tests of vectorised responses against the plant simulated step by step."""

import math
from typing import List, Tuple

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from first_order_sys_sim.first_order_plant import FirstOrderPlant, PlantSettings
from pid_control.identification.record import Record
from pid_control.identification.response import Model, candidate, responses

INPUTS = st.lists(st.tuples(st.floats(0.01, 0.5), st.floats(-1.0, 1.0)), min_size=2, max_size=15)
MODELS = st.builds(
    Model,
    st.floats(-20.0, 20.0),
    st.floats(0.01, 2.0),
    st.floats(0.0, 0.5),
    st.floats(0.0, 0.5),
    st.one_of(st.just(math.inf), st.floats(0.1, 10.0)),
    st.floats(-5.0, 5.0),
    st.just(0.0),
)


@given(INPUTS, st.lists(MODELS, min_size=1, max_size=4), st.floats(-1.0, 1.0))
def test_responses_match_the_sampled_plant(
    inputs: List[Tuple[float, float]], models: List[Model], start: float
) -> None:
    changed_at = numpy.cumsum([0.0] + [after for after, _ in inputs[1:]])
    values = numpy.array([value for _, value in inputs])
    times = numpy.linspace(0.0, changed_at[-1] + 1.0, 40)
    record = Record(changed_at, values, times, times)
    rows = numpy.array([candidate(model, start) for model in models])
    for model, row in zip(models, responses(record, rows)):
        settings = PlantSettings(model.gain, model.time_constant, model.limit, model.dead_zone)
        one = FirstOrderPlant(settings)
        one.set_output(model.dead_time, start - model.offset)
        coming = list(zip(changed_at + model.dead_time, values))
        for time, answer in zip(times, row):
            while coming and coming[0][0] <= time:
                one.hold(*coming.pop(0))
            expected = model.offset + one.output(time)
            assert math.isclose(answer, expected, rel_tol=1e-9, abs_tol=1e-9)


def test_responses_with_friction_leave_the_limit_at_once() -> None:
    changed_at, times = numpy.array([0.0, 5.0]), numpy.array([4.9, 5.0, 5.5])
    record = Record(changed_at, numpy.array([1.0, 0.0]), times, times)
    row = candidate(Model(2.0, 1.0, limit=1.0, friction=0.1), 0.0)
    expected = [1.0, 1.0, 1.2 * math.exp(-0.5) - 0.2]
    assert responses(record, row[None, :])[0].tolist() == pytest.approx(expected)


FRICTION = st.floats(0.0, 0.5)


@given(INPUTS, FRICTION, st.sampled_from([-1.0, 1.0]), st.floats(-1.0, 1.0))
def test_responses_with_friction_match_small_steps(
    inputs: List[Tuple[float, float]], friction: float, sign: float, start: float
) -> None:
    changed_at = numpy.cumsum([0.0] + [after for after, _ in inputs[1:]])
    values, tau, step = numpy.array([value for _, value in inputs]), 0.3, 2e-3
    times = numpy.arange(0.0, min(changed_at[-1], 1.0) + 0.5, step)
    record = Record(changed_at, values, times, times)
    row = candidate(Model(2.0 * sign, tau, friction=friction), start)
    speed, expected = start, []
    for time in times:
        expected.append(speed)
        target = 2.0 * sign * values[numpy.searchsorted(changed_at, time, side="right") - 1]
        if speed == 0.0 and abs(target) <= 2.0 * friction:
            continue
        brake = 2.0 * friction * (numpy.sign(speed) or numpy.sign(target))
        faster = speed + (target - brake - speed) * step / tau
        speed = 0.0 if speed * faster < 0.0 else faster
    assert numpy.abs(responses(record, row[None, :])[0] - expected).max() < 0.05
