"""Tests of the roles of parameters, of the values to try, and of their effects."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.signal_judging.effects import changed_nodes, is_as_predicted
from pid_control.signal_judging.evidence import GENERATOR, PROCESS, TrialFeatures
from pid_control.signal_judging.features import SINE, ProcessFeatures, SignalFeatures
from pid_control.signal_judging.parameter_roles import (
    GENERATOR_ROLES,
    PROCESS_ROLES,
    changed,
    changed_text_or_list,
    is_number,
    role_of,
)
from pid_control.signal_judging.sine_fit import SineFit

BEFORE = TrialFeatures(
    SignalFeatures(10.0, SineFit(2.0, 3.0, 0.1, 0.0, 0.001, 3.0)),
    ProcessFeatures(10.0, SINE, 0.5, (1.0, 1.0), 1.5, 0.5, 0.001, 0),
)


def with_sine(**changes: float) -> TrialFeatures:
    assert BEFORE.signal.sine is not None
    return BEFORE._replace(
        signal=BEFORE.signal._replace(sine=BEFORE.signal.sine._replace(**changes))
    )


def with_process(**changes: Any) -> TrialFeatures:
    assert BEFORE.process is not None
    return BEFORE._replace(process=BEFORE.process._replace(**changes))


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("signalGen_Amplitude", "amplitude"),
        ("signal_omega", "frequency"),
        ("rate_hz", "rate"),
        ("frequency_hz", "frequency"),
        ("sampling_frequency", "rate"),
        ("samples", ""),
        ("phase", "phase"),
        ("Offset", "offset"),
        ("A", ""),
    ],
)
def test_role_of_generator(name: str, role: str) -> None:
    assert role_of(name, GENERATOR_ROLES) == role


@pytest.mark.parametrize(
    ("name", "role"),
    [("process_angle", "phase_shift"), ("amplitude_scale", "gain"), ("f", ""), ("GAIN", "gain")],
)
def test_role_of_process(name: str, role: str) -> None:
    assert role_of(name, PROCESS_ROLES) == role


@given(
    st.one_of(st.integers(-(10**6), 10**6), st.floats(-1e6, 1e6)),
    st.sampled_from(["", *GENERATOR_ROLES, *PROCESS_ROLES]),
    st.booleans(),
)
def test_changed_value_is_another_one_of_the_same_type(value: Any, role: str, far: bool) -> None:
    new = changed(value, role, far)
    assert type(new) is type(value)
    assert new != value or abs(value) < 1e-300


def test_changed_0_and_offset_are_other_values_too() -> None:
    assert (changed(0.0, "gain"), changed(0, ""), changed(1.0, "offset", True)) == (1.0, 1, 1.5)


def test_changed_phase_is_seen_in_rad_and_in_degrees() -> None:
    move = changed(0.0, "phase_shift", is_far=True)
    assert abs(math.remainder(move, 2.0 * math.pi)) > 0.2 and math.radians(move) > 0.2


def test_changed_text_or_list_has_other_numbers() -> None:
    assert changed_text_or_list("2.0", "amplitude") == "3.0"
    assert changed_text_or_list([2, "a", 4.0], "") == [3, "a", 5.0]
    for value in ("sine", "", True, None, {"a": 1}, 2.0):
        assert changed_text_or_list(value, "gain") == value


def test_is_number_excludes_truth_values() -> None:
    assert is_number(1) and is_number(0.5)
    assert not is_number(True) and not is_number("1") and not is_number(None)


@pytest.mark.parametrize(
    ("after", "nodes"),
    [
        (BEFORE, set()),
        (BEFORE._replace(signal=SignalFeatures(10.1, BEFORE.signal.sine)), set()),
        (with_sine(amplitude=2.2), {GENERATOR}),
        (with_sine(frequency=3.1), {GENERATOR}),
        (with_sine(offset=0.1), {GENERATOR}),
        (with_sine(distortion=0.5), {GENERATOR}),
        (with_sine(phase=2.0, periods=9.0), set()),  # depends on when it starts
        (BEFORE._replace(signal=SignalFeatures(12.0, BEFORE.signal.sine)), {GENERATOR}),
        (BEFORE._replace(signal=SignalFeatures(10.0, None)), {GENERATOR}),
        (BEFORE._replace(signal=SignalFeatures(None, BEFORE.signal.sine)), {GENERATOR}),
        (with_process(gain=0.6), {PROCESS}),
        (with_process(shifts=(1.2, 1.2)), {PROCESS}),
        (with_process(shifts=(1.2, 1.0)), set()),
        (with_process(offset=1.6), {PROCESS}),
        (with_process(shape="rectified"), {PROCESS}),
        (with_process(rate=20.0), {PROCESS}),
        (with_process(distortion=0.5), {PROCESS}),
        (with_process(not_finite=1), {PROCESS}),
        (BEFORE._replace(process=None), {PROCESS}),
    ],
)
def test_changed_nodes_names_nodes_with_different_features(
    after: TrialFeatures, nodes: Any
) -> None:
    assert changed_nodes(BEFORE, after) == nodes
    assert changed_nodes(after, BEFORE) == nodes
    assert changed_nodes(after, after) == set()


@pytest.mark.parametrize(
    ("role", "node", "values", "after", "predicted"),
    [
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.4), True),
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.0), False),
        ("frequency", GENERATOR, (5.0, 6.0), with_sine(frequency=3.6), True),
        ("offset", GENERATOR, (0.0, 0.5), with_sine(offset=0.5), True),
        ("offset", GENERATOR, (1.0, 1.5), with_sine(offset=0.5), True),
        ("offset", GENERATOR, (0.0, 0.5), BEFORE, False),
        ("phase", GENERATOR, (0.0, 0.5), with_sine(phase=0.6), False),
        ("rate", GENERATOR, (10, 20), BEFORE._replace(signal=SignalFeatures(20.0, None)), True),
        ("rate", GENERATOR, (10, 20), BEFORE._replace(signal=SignalFeatures(None, None)), False),
        ("offset", GENERATOR, (0, 1), BEFORE._replace(signal=SignalFeatures(10.0, None)), False),
        ("gain", PROCESS, (0.5, 0.7), with_process(gain=0.7), True),
        ("gain", PROCESS, (0.0, 0.7), with_process(gain=0.7), False),
        ("rate", PROCESS, (10, 20), with_process(rate=20.0), True),
        ("phase_shift", PROCESS, (1.0, 1.4), with_process(shifts=(1.4, 1.4)), True),
        ("phase_shift", PROCESS, (1.0, 1.4), with_process(shifts=(0.6, 0.6)), True),
        ("phase_shift", PROCESS, (30, 50), with_process(shifts=(1.349, 1.349)), True),
        ("phase_shift", PROCESS, (30.0, 30.4), BEFORE, False),
        ("offset", PROCESS, (1.5, 2.0), with_process(offset=2.0), True),
        ("offset", PROCESS, (1.5, 2.0), with_process(offset=2.03), True),  # 2 % of it
        ("offset", PROCESS, (1.5, 2.0), with_process(offset=2.06), False),
        ("offset", PROCESS, (3.0, 4.0), with_process(offset=2.0), True),  # before the gain
        ("offset", PROCESS, (9.0, 9.5), with_process(offset=2.0), False),
        ("", PROCESS, (1.0, 2.0), with_process(gain=1.0), False),
        ("gain", PROCESS, (0.5, 0.7), BEFORE._replace(process=None), False),
    ],
)
def test_is_as_predicted(
    role: str, node: str, values: Any, after: TrialFeatures, predicted: bool
) -> None:
    assert is_as_predicted(role, node, values, BEFORE, after) is predicted
