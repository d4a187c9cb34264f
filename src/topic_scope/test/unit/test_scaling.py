"""Scaling of a page's traces, and drawing in steps."""

import math
from typing import Any, Tuple

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.decimation import as_json, bin_of, lasts
from topic_scope.analysis.ring import Samples
from topic_scope.page.view import LiveView
from topic_scope.protocol.checks import TRACES, RequestError
from topic_scope.protocol.requests import View
from topic_scope.protocol.scaling import Scaling, TraceScale, scaling_of

TIMES, VALUES = numpy.array([1.0, 2.0, 3.0]), numpy.array([4.0, math.nan, -1e300])


def samples(name: str, start: float, end: float) -> Samples:
    inside = (TIMES >= start) & (TIMES <= end)
    return TIMES[inside], VALUES[inside]


def test_unscaled_traces_are_unchanged() -> None:
    assert Scaling().scaled(samples) is samples
    assert Scaling({"/a": TraceScale(steps=True)}).scaled(samples) is samples
    times, values = Scaling({"/a": TraceScale(2.0)}).scaled(samples)("/b", 1.0, 2.0)
    assert times.tolist() == [1.0, 2.0] and values[0] == 4.0


def test_gain_is_applied_before_offset() -> None:
    scaled = Scaling(
        {"/a": TraceScale(-2.0, 0.5), "/c": TraceScale(1e300), "/d": TraceScale(offset=1.0)}
    )
    source = scaled.scaled(samples)
    times, values = source("/a", 1.0, 9.0)
    assert times.tolist() == [1.0, 2.0, 3.0]
    assert values[0] == -7.5 and math.isnan(values[1])
    assert source("/c", 3.0, 3.0)[1].tolist() == [-math.inf]  # and no warning
    assert source("/d", 1.0, 1.0)[1].tolist() == [5.0]
    assert VALUES[0] == 4.0


def test_steps() -> None:
    looks = Scaling({"/a": TraceScale(steps=True), "/b": TraceScale(2.0)})
    assert [looks.is_stepped(name) for name in ("/a", "/b", "/c")] == [True, False, False]


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.floats(0.0, 4.0), st.floats(allow_nan=True)), max_size=60),
    st.floats(0.01, 2.0),
    st.integers(-3, 9),
)
def test_the_last_value_of_a_bin_is_the_one_that_holds(
    pairs: Any, width: float, skipped: int
) -> None:
    pairs = sorted(pairs, key=lambda pair: pair[0])
    times = numpy.array([time for time, _ in pairs])
    values = numpy.array([value for _, value in pairs])
    found = as_json(lasts(times, values, skipped, 20, width))
    for index in range(20):
        inside = [
            value
            for time, value in pairs
            if bin_of(time, width) == skipped + index and math.isfinite(value)
        ]
        assert found[index] == (inside[-1] if inside else None)


def test_a_frame_has_last_values_of_steps_alone() -> None:
    view = LiveView(View(1.0, 10, None))
    view.select(["/a", "/b"])
    view.stepped = {"/a": True, "/b": False}.__getitem__

    def source(_name: str, _start: float, _end: float) -> Samples:
        return numpy.array([10.52, 10.55, 10.58]), numpy.array([0.0, 5.0, 3.0])

    frame = view.frame(11.0, source, lambda moment: moment)
    assert frame is not None
    place = 105 - frame["first"]
    assert frame["traces"]["/a"][2 * place : 2 * place + 2] == [0.0, 5.0]
    assert frame["lasts"].keys() == {"/a"} and frame["lasts"]["/a"][place] == 3.0
    assert len(frame["lasts"]["/a"]) == len(frame["traces"]["/a"]) / 2


def test_a_request_is_read() -> None:
    traces = {"/a/x": {"gain": 2, "offset": -1, "steps": True}, "/b.derivative@stamp": {}}
    expected = {"/a/x": TraceScale(2.0, -1.0, True), "/b.derivative@stamp": TraceScale()}
    assert scaling_of({"traces": traces}) == Scaling(expected)


@pytest.mark.parametrize(
    "traces",
    [
        None,
        [],
        {"/a:b": {}},
        {"/a": None},
        {"/a": {"gain": "2"}},
        {"/a": {"gain": None}},
        {"/a": {"gain": 1e301}},
        {"/a": {"offset": math.inf}},
        {"/a": {"offset": True}},
        {"/a": {"steps": 1}},
        {f"/a{number}": {} for number in range(TRACES + 1)},
    ],
)
def test_invalid_request_is_rejected(traces: Tuple[Any, ...]) -> None:
    with pytest.raises(RequestError):
        scaling_of({"traces": traces})
