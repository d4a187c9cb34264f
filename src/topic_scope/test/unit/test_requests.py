"""Requests of pages: valid requests, and rejection of all others."""

import json
import math
import pathlib
import re
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.masks.mask_check import Mask
from topic_scope.protocol import formula_request, requests
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.overlay_request import OverlayRequest, overlay_of
from topic_scope.protocol.requests import Chart, Drive, Handler, Measure, trigger_of
from topic_scope.protocol.scaling import Scaling, TraceScale, scaling_of

CHECKS = {
    "select": requests.selection_of,
    "formula": formula_request.formula_text_of,
    "hide": requests.hidden_of,
    "view": requests.view_of,
    "trigger": requests.trigger_of,
    "scaling": scaling_of,
    "measure": requests.measure_of,
    "chart": requests.chart_of,
    "mask": formula_request.mask_of,
    "graph": requests.graph_of,
    "set": requests.set_of,
    "call": requests.call_of,
    "transition": requests.transition_of,
    "robots": requests.robots_of,
    "steer": requests.steering_of,
    "drive": requests.drive_of,
    "goal": requests.goal_of,
    "playback": requests.playback_of,
    "overlay": overlay_of,
}

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=10,
)
SINGLE = {"type": "trigger", "mode": "single", "field": "/a/x", "level": 0, "edge": "rising"}
GOOD = [
    (
        {"type": "select", "fields": ["/a/x:y", "/a/y"]},
        ("/a/x", "/a/y"),
    ),
    ({"type": "select", "fields": []}, ()),
    ({"type": "hide", "fields": ["/a/x"]}, ("/a/x",)),
    ({"type": "select", "fields": ["../x", "/a/x", "= b +"]}, ("../x", "/a/x", "= b +")),
    ({"type": "select", "fields": ["=/a/x+/b/y"]}, ("=/a/x + /b/y",)),
    (
        {"type": "formula", "text": "=a +", "traces": ["/a/x"]},
        formula_request.FormulaText("=a +", ("/a/x",)),
    ),
    ({"type": "view", "window": 2, "width": 800, "end": None}, requests.View(2.0, 800, None)),
    ({"type": "view", "window": 2, "width": 800, "end": 1.7e9}, requests.View(2.0, 800, 1.7e9)),
    (
        {"type": "trigger", "mode": "normal", "field": "/a/x", "level": -1, "edge": "falling"},
        requests.Trigger("normal", "/a/x", -1.0, False),
    ),
    ({"type": "trigger", "mode": "off"}, requests.Trigger("off", "", 0.0, True)),
    (
        {"type": "trigger", "mode": "off", "number": 2**53 - 1},
        requests.Trigger("off", "", 0.0, True, 2**53 - 1),
    ),
    (
        {**SINGLE, "number": 3},
        requests.Trigger("single", "/a/x", 0.0, True, 3),
    ),
    ({"type": "scaling", "traces": {"/a/x": {"gain": 2}}}, Scaling({"/a/x": TraceScale(2.0)})),
    ({"type": "mask", "field": ""}, None),
    (
        {"type": "mask", "field": "/a/x", "reference": "=/b*2", "value": 0.5, "time": 0},
        Mask("/a/x", "=/b * 2", 0.5, 0.0),
    ),
    ({"type": "measure"}, Measure()),
    ({"type": "measure", "latency": True}, Measure(latency=True)),
    ({"type": "measure", "over_time": 3}, Measure(over_time=3)),
    (
        {"type": "measure", "shapes": True, "against": "/a/x", "start": -2, "end": -1.5},
        Measure(True, "/a/x", -2.0, -1.5),
    ),
    ({"type": "chart", "kind": "time"}, Chart()),
    ({"type": "chart", "kind": "xy", "x": "/a/x"}, Chart("xy", "/a/x")),
    (
        {"type": "chart", "kind": "spectrum", "window": "flattop", "averages": 4},
        Chart("spectrum", "", "flattop", 4),
    ),
    ({"type": "set", "node": "/n", "name": "a", "value": 1}, requests.SetParameter("/n", "a", 1)),
    ({"type": "call", "service": "/n/reset"}, requests.CallService("/n/reset", None)),
    (
        {"type": "call", "service": "/n/enable", "data": True},
        requests.CallService("/n/enable", True),
    ),
    (
        {"type": "transition", "node": "/n", "label": "configure"},
        requests.Transition("/n", "configure"),
    ),
    ({"type": "playback", "playing": False}, requests.Playback(False)),
    ({"type": "playback", "time": 1.7e9, "speed": 2}, requests.Playback(None, 1.7e9, 2.0)),
    ({"type": "overlay", "name": "old", "offset": -1}, OverlayRequest("old", -1.0)),
    ({"type": "overlay", "name": "old", "begin": 1.7e9}, OverlayRequest("old", None, 1.7e9)),
    (
        {"type": "overlay", "name": "old", "trigger": 1.7e9},
        OverlayRequest("old", None, None, 1.7e9),
    ),
    ({"type": "graph", "on": True}, True),
    ({"type": "robots", "on": True}, True),
    ({"type": "steer", "topic": "/cmd_vel"}, "/cmd_vel"),
    ({"type": "steer", "topic": ""}, ""),
    (
        {"type": "drive", "speed": 0.2, "turn": -1, "sent": 12.5},
        requests.Drive(0.2, -1.0, 12.5),
    ),
    (
        {"type": "goal", "topic": "/g", "frame": "odom", "x": 1, "y": -2.5, "heading": 0},
        requests.Goal("/g", "odom", 1.0, -2.5, 0.0),
    ),
]


def understood(text: Any) -> Any:
    """Return the validated request that a handler receives."""
    found = []
    page = object()

    def handle(asking: object, wanted: Any) -> None:
        assert asking is page
        found.append(wanted)

    handlers = {kind: Handler(check, handle) for kind, check in CHECKS.items()}
    requests.dispatch(text, handlers, page)
    (wanted,) = found
    return wanted


@pytest.mark.parametrize("request_, expected", GOOD)
def test_valid_request_is_accepted(request_: Any, expected: Any) -> None:
    assert understood(json.dumps(request_)) == expected


@pytest.mark.parametrize(
    "request_",
    [
        {"type": "playback", "playing": 1},
        {"type": "playback", "time": -1.0},
        {"type": "playback", "speed": 0},
        {"type": "select", "fields": "/a/x"},
        {"type": "select", "fields": ["/a/x"] * 33},
        {"type": "select", "fields": ["/a/" + ":".join(f"x{n}" for n in range(40))]},
        {"type": "select", "fields": ["/a/x", 1]},
        {"type": "view", "window": 0, "width": 800},
        {"type": "robots", "on": 1},
        {"type": "steer"},
        {"type": "steer", "topic": "a" * 301},
        {"type": "drive", "speed": math.nan, "turn": 0, "sent": 0},
        {"type": "drive", "speed": 101, "turn": 0, "sent": 0},
        {"type": "drive", "speed": 0, "turn": True, "sent": 0},
        {"type": "drive", "speed": 0, "turn": 0},
        {"type": "goal", "topic": "/g", "frame": "", "x": 0, "y": 0, "heading": 0},
        {"type": "goal", "topic": "/g", "frame": "odom", "x": 1e7, "y": 0, "heading": 0},
        {"type": "view", "window": math.nan, "width": 800},
        {"type": "view", "window": 1, "width": 10**9},
        {"type": "view", "window": True, "width": 800},
        {"type": "view", "window": 1, "width": 800, "end": -1},
        {"type": "view", "window": 1, "width": 800, "end": "now"},
        {"type": "trigger", "mode": "free", "field": "/a/x", "level": 0, "edge": "rising"},
        {
            "type": "trigger",
            "mode": "auto",
            "field": "/a/x",
            "level": 0,
            "edge": "rising",
            "hysteresis": -1,
        },
        {"type": "trigger", "mode": "normal", "field": "/a/x:y", "level": 0, "edge": "rising"},
        {"type": "trigger", "mode": "normal", "field": "/a/x", "level": 0, "edge": "up"},
        {"type": "trigger", "mode": "normal", "field": "/a/x", "level": math.inf, "edge": "rising"},
        {"type": "trigger", "mode": "off", "number": -1},
        {"type": "trigger", "mode": "off", "number": 2**53},
        {"type": "trigger", "mode": "off", "number": None},
        {"type": "set", "node": "/n", "name": "a"},
        {"type": "set", "node": "/n", "name": "a", "value": None},
        {"type": "set", "node": "", "name": "a", "value": 1},
        {"type": "set", "node": "/n", "name": "a" * 400, "value": 1},
        {"type": "set", "node": "/n", "name": "a", "value": {"b": 1}},
        {"type": "call", "service": "/n/enable", "data": 1},
        {"type": "call"},
        {"type": "overlay", "name": "old", "offset": "1"},
        {"type": "overlay", "name": "old", "offset": 1e10},
        {"type": "overlay", "name": "old", "begin": 1.0, "trigger": 1.0},
        {"type": "overlay", "offset": 1.0},
        {"type": "graph", "on": 1},
        {"type": ["select"]},
        {"type": "formula", "text": "/a/x", "traces": []},
        {"type": "shutdown"},
        {},
        [],
        None,
        "select",
    ],
)
def test_invalid_request_is_rejected_with_a_reason(request_: Any) -> None:
    with pytest.raises(RequestError, match="[a-z]"):
        understood(json.dumps(request_))


@pytest.mark.parametrize(
    "changes, sentence",
    [
        ({"field": "not a name"}, "mask: .*not a name"),
        ({"reference": "=/b/x +"}, "mask: unexpected end of the formula"),
        ({"time": 601}, "mask: time must be a number from 0 to 600"),
        ({"reference": "=delay(/b/x, 9)", "time": 595}, "mask: .* reach over 604 s: at most 600"),
        ({"reference": f"=-/b/x{'+-/b/x' * 17}"}, "mask: a formula has at most"),
    ],
)
def test_a_mask_that_could_never_check_is_rejected(changes: Any, sentence: str) -> None:
    mask = {"type": "mask", "field": "/a/x", "reference": "/b/x", "value": 1, "time": 0}
    with pytest.raises(RequestError, match=sentence):
        understood(json.dumps({**mask, **changes}))


@settings(max_examples=30)
@given(st.text(max_size=200) | st.binary(max_size=50))
def test_garbage_is_rejected(text: Any) -> None:
    with pytest.raises(RequestError):
        understood(text)


def test_deeply_nested_json_is_rejected() -> None:
    with pytest.raises(RequestError):
        understood("[" * 60000)


@settings(max_examples=30)
@given(
    st.sampled_from(["select", "view", "trigger", "set", "call", "graph", "overlay"]),
    st.dictionaries(
        st.sampled_from(
            "fields window width end mode field level edge node name value service data on"
            " offset begin".split()
        ),
        JSON | st.sampled_from(["normal", "rising", "/a/x", 1.0]),
        max_size=6,
    ),
)
def test_request_with_any_values_is_accepted_or_rejected(kind: str, values: Any) -> None:
    try:
        wanted = understood(json.dumps({**values, "type": kind}))
    except RequestError:
        return
    types = {"select": tuple, "graph": bool, "overlay": OverlayRequest}
    assert isinstance(wanted, types.get(kind) or getattr(requests, kind.capitalize()))


def test_the_page_has_the_version_of_the_protocol() -> None:
    link = pathlib.Path(__file__).parents[2] / "www" / "js" / "base" / "link.js"
    (found,) = re.findall(r"^const PROTOCOL = (\d+);", link.read_text("utf-8"), re.MULTILINE)
    assert int(found) == requests.VERSION


def test_measured_span_is_relative_to_its_reference_in_either_direction() -> None:
    assert Measure(start=1.0, end=-2.0).span(100.0) == (98.0, 101.0)
    assert Measure(start=-2.0, end=1.0, reference=50.0).span(100.0) == (48.0, 51.0)
    assert Measure(start=1.0).span(100.0) is None


def test_turning_on_the_spot_is_no_stop() -> None:
    assert Drive(0.0, 0.0, 1.0).is_stop
    assert not Drive(0.0, 0.5, 1.0).is_stop and not Drive(0.5, 0.0, 1.0).is_stop


def test_holdoff_may_be_as_long_as_a_view() -> None:
    request = {"mode": "auto", "field": "/a/x", "level": 0.0, "edge": "rising"}
    assert trigger_of({**request, "holdoff": 3600.0}).holdoff == 3600.0
