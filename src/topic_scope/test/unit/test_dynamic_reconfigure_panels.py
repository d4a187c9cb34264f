"""Panels of dynamic_reconfigure servers."""

from unittest import mock

import pytest
from dynamic_reconfigure.msg import ConfigDescription, Group, ParamDescription

from nodekit import ParameterError
from topic_scope.controls import dynamic_reconfigure_panels
from topic_scope.controls.panel import ParameterPanel
from topic_scope.controls.dynamic_reconfigure_panels import _words, config_of, described, values_in

VALUES = {"gain": 2.5, "count": -7, "on": False, "mode": "fast"}
MODES = "{'enum': [{'name': 'Slow', 'value': 'slow'}, {'name': 'Fast', 'value': 'fast'}]}"
COUNTS = "{'enum': [{'name': 'Few', 'value': 1}, {'name': 'Many', 'value': 9}]}"


def description(counts: str = "") -> ConfigDescription:
    parameters = [
        ParamDescription("gain", "double", 0, "the gain", ""),
        ParamDescription("count", "int", 0, "the count", counts),
        ParamDescription("on", "bool", 0, "the switch", ""),
    ]
    mode = ParamDescription("mode", "str", 0, "the mode", MODES)
    return ConfigDescription(
        groups=[Group(parameters=parameters), Group(name="more", parameters=[mode], id=1)],
        min=config_of({"gain": 0.0, "count": -(2**31), "on": False, "mode": ""}),
        max=config_of({"gain": 10.0, "count": 2**31 - 1, "on": True, "mode": ""}),
    )


def panel() -> ParameterPanel:
    entries = described(description(), config_of(VALUES))
    return ParameterPanel("/foreign", entries, {})


def test_all_types_have_values_and_limits() -> None:
    shown = {entry["name"]: entry for entry in panel().message()["parameters"]}
    assert {name: entry["value"] for name, entry in shown.items()} == VALUES
    types = {name: entry["kind"] for name, entry in shown.items()}
    assert types == {"gain": "float", "count": "int", "on": "bool", "mode": "enum"}
    assert (shown["gain"]["minimum"], shown["gain"]["maximum"]) == (0.0, 10.0)
    count = described(description(), config_of(VALUES))[1]
    assert not {"minimum", "maximum"} & set(count)  # the bounds of the type are not limits
    assert shown["mode"]["choices"] == ["slow", "fast"]
    assert shown["gain"]["help"] == "the gain"


def test_values_are_validated_before_they_are_sent() -> None:
    assert panel().check("gain", 9) == 9.0
    with pytest.raises(ParameterError, match="gain: refused 11: must be"):
        panel().check("gain", 11.0)
    with pytest.raises(ParameterError, match="one of slow, fast"):
        panel().check("mode", "wavy")


def test_values_are_transferred_unchanged() -> None:
    assert values_in(config_of(VALUES)) == VALUES


def test_described_parameter_without_a_value_is_left_out() -> None:
    known = {name: value for name, value in VALUES.items() if name != "gain"}
    assert [one["name"] for one in described(description(), config_of(known))] == [
        "count",
        "on",
        "mode",
    ]


def test_parameter_of_an_unknown_type_is_left_out() -> None:
    unknown = description()
    unknown.groups[0].parameters[0].type = "matrix"
    names = [one["name"] for one in described(unknown, config_of(VALUES))]
    assert names == ["count", "on", "mode"]


def test_reply_to_a_change_names_the_values_that_the_node_chose(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    reply = mock.Mock()
    reply.result.return_value.config = config_of({**VALUES, "gain": 10.0})
    call = mock.Mock(return_value=reply)
    monkeypatch.setattr(dynamic_reconfigure_panels, "call_service", call)
    changed = dynamic_reconfigure_panels.change("/foreign", {"gain": 12.0, "count": -7})
    assert call.call_args[0][0] == "/foreign/set_parameters"
    assert values_in(call.call_args[0][2]) == {"gain": 12.0, "count": -7}
    assert changed == (False, "/foreign changed it to gain = 10.0", {"gain": 10.0, "count": -7})
    assert dynamic_reconfigure_panels.change("/foreign", {"count": -7}).success


@pytest.mark.parametrize("text", ["", "x", "{}", "[1]", "{'enum': 3}", "__import__('os')", "((((("])
def test_non_enum_has_no_labels(text: str) -> None:
    assert _words(text) == {}


def test_enum_numbers_have_labels() -> None:
    entries = described(description(COUNTS), config_of(VALUES))
    shown = ParameterPanel("/foreign", entries, {}).message()["parameters"]
    labels = {entry["name"]: entry["labels"] for entry in shown}
    assert labels == {"gain": [], "count": [(1, "Few"), (9, "Many")], "on": [], "mode": []}


@pytest.mark.parametrize("pairs", [3, [3], [["a", "b"]], [[1, 2, 3]], None])
def test_invalid_labels_are_left_out(pairs: object) -> None:
    entry = {"name": "a", "type": "int", "default": 1, "value": 1, "labels": pairs}
    assert ParameterPanel("/foreign", [entry], {}).message()["parameters"][0]["labels"] == []
