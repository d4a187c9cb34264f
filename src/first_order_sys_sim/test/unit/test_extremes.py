"""For any messages and parameters, the node's output fits into a message."""

import math
from typing import Any, List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from first_order_sys_sim.sampled_plant import SampledPlant
from first_order_sys_sim.system_parameters import SystemParameters
from nodekit import LARGEST_FLOAT32
from nodekit.testing.offline_parameters import OfflineParameters

NUMBERS = st.floats() | st.integers() | st.sampled_from([0, -0.0, 5e-324, 1e-320, 1e308, 10**400])
SCALARS = st.none() | st.booleans() | NUMBERS | st.text(max_size=5) | st.just("euler")
YAML = SCALARS | st.lists(SCALARS, max_size=2) | st.dictionaries(st.text(max_size=2), SCALARS)
CHANGES = st.dictionaries(st.sampled_from(sorted(SystemParameters.declared)), YAML, max_size=4)
#: Finite Float32 values: the node ignores others.
INPUTS = st.floats(-LARGEST_FLOAT32, LARGEST_FLOAT32, width=32)


@pytest.mark.parametrize("name", SystemParameters.declared)
@given(raw=YAML)
def test_any_value_is_accepted_or_rejected_with_message(name: str, raw: Any) -> None:
    parameters = OfflineParameters(SystemParameters)
    defaults = parameters.values
    errors = parameters.set({name: raw})
    value = getattr(parameters.values, name)
    assert isinstance(value, str) or math.isfinite(value)
    for error in errors:
        assert ": refused " in str(error) and ": must be " in str(error)
        assert parameters.values == defaults


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), INPUTS, CHANGES), max_size=8))
def test_output_is_finite_and_within_its_limit(steps: List[Tuple[float, float, Any]]) -> None:
    parameters = OfflineParameters(SystemParameters)
    values = parameters.values
    plant = SampledPlant(values.plant, values.system_sample_time)
    time = 0.0
    for interval, value, changes in steps:
        time += interval  # also backwards
        parameters.set(changes)
        values = parameters.values
        plant.change(time, values.plant, values.system_sample_time)
        plant.set_input(time, value)
        for moment in (time, time + 1e-3, time + 1.0):
            assert abs(plant.output(moment)) <= values.system_max_output


@given(st.floats(0.0, 1e6, exclude_min=True), st.sampled_from(["exact", "euler"]))
def test_plant_at_rest_stays_at_rest(time_constant: float, method: str) -> None:
    values = SystemParameters(system_param_T=time_constant, method=method)
    plant = SampledPlant(values.plant, values.system_sample_time)
    assert [plant.output(number * 0.01) for number in range(10)] == [0.0] * 10
