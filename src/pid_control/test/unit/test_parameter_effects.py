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
    values_in_rad,
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
        ("publ_frequency", "rate"),
        ("update_freq", "rate"),
        ("loop_omega", "rate"),
        ("rate_of_freq", "rate"),
        ("shift", "phase"),
        ("ampl_offset", "amplitude"),
        ("hz", "rate"),
        ("amplitude_rate", "rate"),
        ("sampl_ampl", "amplitude"),
    ],
)
def test_role_of_generator(name: str, role: str) -> None:
    assert role_of(name, GENERATOR_ROLES) == role


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("process_angle", "phase_shift"),
        ("amplitude_scale", "gain"),
        ("f", ""),
        ("GAIN", "gain"),
        ("scale", "gain"),
        ("factor", "gain"),
        ("phase", "phase_shift"),
        ("shift_gain", "phase_shift"),
        ("offset_gain", "offset"),
        ("rate_offset", "rate"),
        ("frequency", ""),
    ],
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


@pytest.mark.parametrize(
    ("role", "near", "far"),
    [
        ("rate", 20.0, 40.0),
        ("amplitude", 15.0, 22.5),
        ("frequency", 12.5, 15.625),
        ("gain", 14.0, 19.6),
        ("offset", 10.5, 10.5),
        ("phase", 10.4, 30.0),
        ("phase_shift", 10.4, 30.0),
        ("", 12.5, 15.625),
    ],
)
def test_changed_value_depends_on_the_role(role: str, near: float, far: float) -> None:
    assert changed(10.0, role) == pytest.approx(near)
    assert changed(10.0, role, is_far=True) == pytest.approx(far)
    assert (changed(10, role), changed(10, role, True)) == (
        round(near) if round(near) != 10 else 11,
        round(far) if round(far) != 10 else 11,
    )


def test_changed_0_and_offset_are_other_values_too() -> None:
    assert (changed(0.0, "gain"), changed(0, ""), changed(1.0, "offset", True)) == (1.0, 1, 1.5)
    assert (changed(0.0, "gain", True), changed(1, "gain")) == (1.0, 2)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("/a/f_Hz", (6.0,)),
        ("/hz/f", (3.0, 6.0)),
        ("/f_Rad", (3.0,)),
        ("/rad/f", (3.0, 6.0)),
        ("f", (3.0, 6.0)),
    ],
)
def test_values_in_rad_are_those_that_the_name_allows(name: str, values: Any) -> None:
    assert values_in_rad(name, 3.0, 2.0, "hz") == values


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
        (BEFORE._replace(signal=SignalFeatures(10.4, BEFORE.signal.sine)), set()),
        (BEFORE._replace(signal=SignalFeatures(10.6, BEFORE.signal.sine)), {GENERATOR}),
        (BEFORE._replace(signal=SignalFeatures(10.6, None)), {GENERATOR}),
        (with_sine(amplitude=2.03), set()),
        (with_sine(amplitude=2.05), {GENERATOR}),
        (with_sine(frequency=3.025), set()),
        (with_sine(frequency=3.035), {GENERATOR}),
        (with_sine(offset=0.035), set()),
        (with_sine(offset=0.045), {GENERATOR}),
        (with_sine(distortion=0.1), set()),
        (with_sine(distortion=0.11), {GENERATOR}),
        (with_sine(phase=2.0, periods=9.0), set()),  # depends on when it starts
        (BEFORE._replace(signal=SignalFeatures(12.0, BEFORE.signal.sine)), {GENERATOR}),
        (BEFORE._replace(signal=SignalFeatures(10.0, None)), {GENERATOR}),
        (BEFORE._replace(signal=SignalFeatures(None, BEFORE.signal.sine)), {GENERATOR}),
        (with_process(gain=0.505), set()),
        (with_process(gain=0.515), {PROCESS}),
        (with_process(shifts=(1.05, 1.05)), set()),
        (with_process(shifts=(1.07, 1.07)), {PROCESS}),
        (with_process(shifts=(1.2, 1.0)), set()),
        (with_process(offset=1.525), set()),
        (with_process(offset=1.535), {PROCESS}),
        (with_process(shape="rectified"), {PROCESS}),
        (with_process(rate=10.4), set()),
        (with_process(rate=10.6), {PROCESS}),
        (with_process(rate=None), {PROCESS}),
        (with_process(distortion=0.1), set()),
        (with_process(distortion=0.11), {PROCESS}),
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
    ("before", "after", "is_changed"),
    [
        ({"offset": 0.0}, {"offset": 0.009}, False),  # a share of the amplitude
        ({"offset": 0.0}, {"offset": 0.011}, True),
        ({"offset": -1.5}, {"offset": -1.475}, False),
        ({"offset": -1.5}, {"offset": -1.465}, True),
        ({"not_finite": 1}, {"not_finite": 2}, False),
    ],
)
def test_changed_nodes_compares_with_the_output_before(
    before: Any, after: Any, is_changed: bool
) -> None:
    nodes = changed_nodes(with_process(**before), with_process(**after))
    assert nodes == ({PROCESS} if is_changed else set())


@pytest.mark.parametrize(
    ("role", "node", "values", "after", "predicted"),
    [
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.4), True),
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.44), True),
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.46), False),
        ("amplitude", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.0, frequency=3.6), False),
        ("frequency", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.4), False),
        ("", GENERATOR, (5.0, 6.0), with_sine(amplitude=2.4, frequency=3.6), False),
        ("offset", GENERATOR, (0.0, 0.5), with_sine(offset=0.535), True),
        ("offset", GENERATOR, (0.0, 0.5), with_sine(offset=0.545), False),
        ("rate", GENERATOR, (10, 20), BEFORE._replace(signal=SignalFeatures(20.9, None)), True),
        ("rate", GENERATOR, (10, 20), BEFORE._replace(signal=SignalFeatures(21.1, None)), False),
        ("rate", PROCESS, (10, 20), with_process(rate=21.1), False),
        ("gain", PROCESS, (0.5, 0.7), with_process(gain=0.715), False),
        ("phase_shift", PROCESS, (1.0, 1.4), with_process(shifts=(1.45, 1.45)), True),
        ("phase_shift", PROCESS, (1.0, 1.4), with_process(shifts=(1.47, 1.47)), False),
        ("offset", PROCESS, (1.5, 0.2), with_process(offset=0.209), True),  # 2 % of the gain
        ("offset", PROCESS, (1.5, 0.2), with_process(offset=0.211), False),
        ("offset", PROCESS, (1.5, -1.5), with_process(offset=-1.525), True),
        ("offset", PROCESS, (1.4, 2.0), with_process(offset=2.0), False),  # not its value before
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


def test_is_as_predicted_without_a_feature_before_is_false() -> None:
    values = (0.5, 0.7)
    for before in (BEFORE._replace(process=None), with_process(gain=0.0)):
        assert not is_as_predicted("gain", PROCESS, values, before, with_process(gain=0.7))
    before = BEFORE._replace(signal=SignalFeatures(10.0, None))
    assert not is_as_predicted("amplitude", GENERATOR, values, before, BEFORE)
