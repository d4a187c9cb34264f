"""Computed traces, with samples in any portions."""

import math
from typing import List

import numpy
import pytest
from bags import first_messages
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.waveform import phase
from topic_scope.bag.columns import choose
from topic_scope.messages.field_functions import FUNCTIONS, make, parts
from topic_scope.messages.fields import FieldError, expand, parted
from topic_scope.timing.nanoseconds import array_to_ns

from geometry_msgs.msg import PoseStamped, Quaternion  # isort: skip

cuts = st.lists(st.integers(0, 400), max_size=6)


def samples_of(
    name: str, times: numpy.ndarray, rows: numpy.ndarray, cuts: List[int], longest: float = math.inf
) -> numpy.ndarray:
    """Return times and values computed from samples that arrive in parts."""
    function, edges, at = make(name), [0] + sorted(cuts) + [len(times)], array_to_ns(times)
    found = [function(at[a:b], rows[:, a:b], longest) for a, b in zip(edges, edges[1:]) if a < b]
    made, values = (numpy.concatenate(parts) for parts in zip(*found))
    return numpy.array([made / 1e9, values])


def computed(
    name: str, times: numpy.ndarray, rows: numpy.ndarray, cuts: List[int]
) -> numpy.ndarray:
    """Return the values computed from samples that arrive in parts."""
    values: numpy.ndarray = samples_of(name, times, rows, cuts)[1]
    return values


@given(cuts, st.floats(0.1, 20.0))
@settings(max_examples=30)
def test_a_derivative_is_the_slope(cuts: List[int], omega: float) -> None:
    times = 1.7e9 + numpy.arange(400) / 512.0
    values = numpy.sin(omega * (times - 1.7e9))[None]
    made, found = samples_of("derivative", times, values, cuts)
    middles = times[1:] - 1.7e9 - 0.5 / 512.0
    assert made - 1.7e9 == pytest.approx(middles, abs=5e-7)
    assert found == pytest.approx(omega * numpy.cos(omega * middles), abs=omega**3 / 2.5e5 + 1e-6)
    steps = computed("difference", times, numpy.arange(400.0)[None] ** 2, cuts)
    assert steps.tolist() == [2 * index + 1 for index in range(399)]


@pytest.mark.parametrize("hertz", [1.0, 10.0, 30.0])
def test_derivative_leads_by_90_degrees(hertz: float) -> None:
    times = 1.7e9 + numpy.arange(1000) / 100.0
    values = numpy.sin(2.0 * math.pi * hertz * times)
    ahead = phase(tuple(samples_of("derivative", times, values[None], [])), (times, values))
    assert ahead.value == pytest.approx(90.0, abs=0.1)


def test_derivative_is_missing_in_a_gap() -> None:
    times, values = numpy.array([1.0, 2.0, 9.0, 10.0]), numpy.arange(4.0)[None]
    made, found = samples_of("derivative", times, values, [], longest=5.0)
    assert made.tolist() == [1.5, 5.5, 9.5]
    assert found[0] == 1.0 and numpy.isnan(found[1]) and found[2] == 1.0


def test_late_sample_has_no_step() -> None:
    times, values = numpy.array([1.0, 2.0, 2.0, 1.5, 3.0]), numpy.arange(5.0)[None]
    made, found = samples_of("derivative", times, values, [2])
    assert made.tolist() == [1.5, 2.0, 1.5, 2.25]
    assert found[0] == 1.0 and numpy.isnan(found[1:3]).all() and found[3] == pytest.approx(1 / 1.5)


@given(cuts, st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
@settings(max_examples=30)
def test_angle_is_unwrapped(cuts: List[int], step: float, start: float) -> None:
    turned = start + step * numpy.arange(400)
    wrapped = numpy.arctan2(numpy.sin(turned), numpy.cos(turned))
    wrapped[7] = math.nan  # a missing sample
    found = computed("unwrap", turned, wrapped[None], cuts)
    assert numpy.isnan(found[7])
    found[7] = turned[7]
    assert found == pytest.approx(turned, abs=1e-9)


@settings(max_examples=30)
@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1), st.floats(0.1, 10.0))
def test_the_yaw_of_a_quaternion(yaw: float, pitch: float, roll: float, length: float) -> None:
    (cy, sy), (cp, sp), (cr, sr) = (
        (math.cos(angle / 2), math.sin(angle / 2)) for angle in (yaw, pitch, roll)
    )
    quaternion = [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy]
    quaternion += [cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
    _, found = make("yaw")(numpy.zeros(1, int), length * numpy.array(quaternion)[:, None], math.inf)
    assert found[0] == pytest.approx(yaw, abs=1e-6)
    assert numpy.isnan(make("yaw")(numpy.zeros(1, int), numpy.zeros((4, 1)), math.inf)[1][0])


@settings(max_examples=30)
@given(st.sampled_from(FUNCTIONS), st.lists(st.floats(), max_size=30))
def test_anything_can_be_computed(name: str, values: List[float]) -> None:
    rows = numpy.array([values] * len(parts(name)), float)
    with numpy.errstate(all="ignore"):
        found = computed(name, numpy.arange(float(len(values))), rows, []) if values else []
    assert len(values) - 1 <= len(found) <= len(values)


def test_names() -> None:
    assert expand("/a/x:y.derivative@stamp") == ["/a/x.derivative@stamp", "/a/y.derivative@stamp"]
    assert parted("/a/x[3].unwrap@t/u") == ("/a/x[3]", "unwrap", "t/u")
    assert parted("/a/x") == ("/a/x", "", "")
    for wrong in ("/a/x.", "/a/x.eval", "/a.yaw/x", "/a/x.yaw.unwrap", "/a/x@stamp.yaw"):
        with pytest.raises(FieldError):
            expand(wrong)


def test_quaternions_are_found_in_a_message() -> None:
    messages = first_messages({"/pose": PoseStamped(), "/turn": Quaternion()})
    names = [column.name for column in choose(["/pose.yaw", "/turn.yaw@received"], messages)]
    assert names == ["/pose/pose/orientation.yaw", "/turn.yaw@received"]
    with pytest.raises(FieldError, match="no quaternion in pose/position"):
        choose(["/pose/pose/position.yaw"], messages)
