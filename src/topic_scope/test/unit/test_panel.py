"""Panels built from the nodes' declarations, with the nodes' validation."""

import json
import math
from typing import Any, Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodekit import (
    BoolParameter,
    BytesParameter,
    DescriptionError,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterSet,
    StringParameter,
    describe,
)
from topic_scope.controls.panel import ParameterPanel

NODE = "/lab/gauge"


class Gauge(ParameterSet):
    """Parameters of every type, and with every type of limit."""

    level = FloatParameter(1.0, above=0.0, maximum=1e10, unit="V", help="a level")
    slope = FloatParameter(0.5, minimum=-1.0, below=1.0, help="a slope")
    free = FloatParameter(0.5, help="any number")
    count = IntParameter(3, minimum=0, help="a count")
    on = BoolParameter(False, help="a switch")
    title = StringParameter("gauge", help="a title: any text")
    shape = EnumParameter("round", choices=("round", "flat, wide"), help="a shape")
    angle = FloatParameter(0.0, minimum=-2 * math.pi, maximum=2 * math.pi, help="exact ends")
    marks = ListParameter([1.0, 2.0], element=FloatParameter(0.0, help=""), help="marks")


def panel(**values: Any) -> ParameterPanel:
    services = {NODE + "/reset": "Trigger"}
    return ParameterPanel(NODE, describe(Gauge(**values)), services)


def shown(name: str) -> Any:
    entries = {entry["name"]: entry for entry in panel().message()["parameters"]}
    return entries[name]


def test_panel_shows_the_declarations() -> None:
    message = panel().message()
    assert message["node"] == NODE
    assert message["services"] == [{"name": NODE + "/reset", "kind": "Trigger"}]
    names = [entry["name"] for entry in message["parameters"]]
    assert names == list(Gauge.declared)
    assert shown("level") == {
        "name": "level",
        "kind": "float",
        "unit": "V",
        "help": "a level",
        "value": 1.0,
        "minimum": None,
        "maximum": 1e10,
        "above": 0.0,
        "below": None,
        "choices": [],
        "labels": [],
    }
    assert (shown("slope")["minimum"], shown("slope")["below"]) == (-1.0, 1.0)
    assert [shown("free")[end] for end in ("minimum", "maximum", "above", "below")] == [None] * 4
    assert shown("count")["maximum"] == 2**31 - 1
    assert shown("shape")["choices"] == ["round", "flat, wide"]
    assert (shown("angle")["minimum"], shown("angle")["maximum"]) == (-2 * math.pi, 2 * math.pi)
    assert [shown(name)["kind"] for name in ("on", "title", "marks")] == [
        "bool",
        "string",
        "string",
    ]
    assert shown("marks")["value"] == "[1.0, 2.0]"


VALUES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["round", "flat, wide", "1e3", "-0.5", 2 * math.pi, 6.28318530718])
    | st.floats(-2.0, 2.0)
)


@settings(max_examples=30)
@given(st.sampled_from([name for name in Gauge.declared if name != "marks"]), VALUES)
def test_values_are_validated_as_by_the_node(name: str, value: Any) -> None:
    try:
        expected: Any = getattr(Gauge(**{name: value}), name)
    except ParameterError as error:
        with pytest.raises(ParameterError) as caught:
            panel().check(name, value)
        assert str(caught.value) == str(error).replace(name, f"{NODE}/{name}", 1)
        return
    result = panel().check(name, value)
    assert result == expected and type(result) is type(expected)


@pytest.mark.parametrize("value, expected", [("[1, 2.5]", (1, 2.5)), ([3.0], (3.0,)), ("[]", ())])
def test_a_list_is_written_as_yaml(value: Any, expected: Any) -> None:
    assert panel().check("marks", value) == expected


@pytest.mark.parametrize(
    "value", ["1.0", "[1", "[1, x]", "{a: 1}", 5, "!!python/object/new:list [[1]]"]
)
def test_non_list_is_rejected(value: Any) -> None:
    with pytest.raises(ParameterError, match="must be a list of 0 to 1000 elements, each a number"):
        panel().check("marks", value)


def test_bytes_are_shown_and_written_as_yaml() -> None:
    class Lock(ParameterSet):
        key = BytesParameter(b"\x00\xff", max_length=2, help="what opens it")

    locked = ParameterPanel(NODE, describe(Lock()), {})
    assert json.loads(json.dumps(locked.message()))["parameters"][0]["value"] == "[0, 255]"
    for text in ("[1]", "!!binary AQ=="):
        assert locked.check("key", text) == b"\x01"
    for value in ("AQ==", "[1, 2, 3]", "[1", 5):
        with pytest.raises(ParameterError, match="must be at most 2 bytes"):
            locked.check("key", value)


def test_panel_follows_valid_values_only() -> None:
    followed = panel()
    raw = {"level": -1, "count": 5, "on": True, "shape": "wavy", "marks": [4.0], "other": 1}
    assert sorted(followed.follow(raw)) == ["count", "marks", "on"]
    assert followed.follow(raw) == []
    assert followed.values["level"] == 1.0
    assert followed.shown_value("marks") == "[4.0]"


GOOD = {"name": "a", "value": 1, "type": "int", "unit": "", "help": "", "minimum": 0, "maximum": 5}


@pytest.mark.parametrize(
    "entry",
    [
        {**GOOD, "type": "complex"},
        {**GOOD, "maximum": "5"},
        {**GOOD, "value": 7},
        {**GOOD, "type": "enum"},
        {"name": "a"},
    ],
)
def test_invalid_description_is_rejected(entry: Mapping[str, Any]) -> None:
    with pytest.raises(DescriptionError):
        ParameterPanel(NODE, [entry], {})
