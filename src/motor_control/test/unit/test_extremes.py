"""For any messages and parameters, the nodes' outputs fit into a message."""

import math
from typing import Any, List, Tuple, Type

import pytest
from hypothesis import given
from hypothesis import strategies as st

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from motor_control.motor_parameters import MotorParameters
from motor_control.nodes.set_point import SetPointParameters
from nodekit import LARGEST_FLOAT32
from nodekit.testing.offline_parameters import OfflineParameters

NUMBERS = st.floats() | st.integers() | st.sampled_from([0, -0.0, 5e-324, 1e-320, 1e308, 10**400])
SCALARS = st.none() | st.booleans() | NUMBERS | st.text(max_size=5)
YAML = SCALARS | st.lists(SCALARS, max_size=2) | st.dictionaries(st.text(max_size=2), SCALARS)
CHANGES = st.dictionaries(st.sampled_from(sorted(MotorParameters.declared)), YAML, max_size=3)
#: Finite Float32 values: the node ignores others.
INPUTS = st.floats(-LARGEST_FLOAT32, LARGEST_FLOAT32, width=32)
#: The set point's other parameters are those of basic_comms' signal, which are tested there.
DECLARED: List[Tuple[Type[Any], str]] = [
    (MotorParameters, each) for each in MotorParameters.declared
]
DECLARED += [(SetPointParameters, "omega")]


@pytest.mark.parametrize("kind, name", DECLARED, ids=lambda part: getattr(part, "__name__", part))
@given(raw=YAML)
def test_any_value_is_accepted_or_rejected_with_message(kind: Any, name: str, raw: Any) -> None:
    parameters = OfflineParameters(kind)
    defaults = parameters.values
    errors = parameters.set({name: raw})
    value = getattr(parameters.values, name)
    assert isinstance(value, type(getattr(defaults, name)))
    assert not isinstance(value, float) or math.isfinite(value)
    for error in errors:
        assert ": refused " in str(error) and ": must be " in str(error)
        assert parameters.values == defaults


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), INPUTS, CHANGES), max_size=8))
def test_speed_is_finite_and_fits_into_a_float32(steps: List[Tuple[float, float, Any]]) -> None:
    parameters = OfflineParameters(MotorParameters)
    values = parameters.values
    plant = FirstOrderPlant(values.plant)
    time = 0.0
    for interval, value, changes in steps:
        time += interval  # also backwards
        parameters.set(changes)
        values = parameters.values
        plant.change(time, values.plant)
        plant.hold(time, value)
        for moment in (time, time + 1e-3, time + 1.0):
            assert abs(plant.output(moment)) <= LARGEST_FLOAT32
