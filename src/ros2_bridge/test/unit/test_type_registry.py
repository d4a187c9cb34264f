"""Tests of the registry of types, with definitions of ROS 1 in a folder and classes for ROS 2's."""

import pathlib
import struct
import sys
import types
from typing import Any, Callable, Dict

import pytest
import rospkg

from ros2_bridge.rules.skip_log import Unbridgeable
from ros2_bridge.types.mapping_rules import MappingRuleError
from ros2_bridge.types.type_registry import TypeRegistry

BRIDGE = pathlib.Path(__file__).resolve().parents[2]
#: Definitions in ROS 1, and fields in ROS 2 by type.
ROS1 = {
    "Arm": "int16 left\nint16 right\n",
    "Arms": "Arm one\nArm[] all\n",
    "Range": "int16 x\n",
    "arm_pair": "signal_msg first\nArm[] all\n",
    "signal_msg": "int16 y\n",
    "imu_data": "int16 z\n",
    "Hands": "int16 z\nArm one\n",
    "Scan": "Range one\nint16 seq\n",
}
ROS2 = {
    "acme_msgs/Arm": {"left": "int16", "right": "int16"},
    "acme_msgs/Arms": {"one": "acme_msgs/Arm", "all": "sequence<acme_msgs/Arm>"},
    "acme_msgs/Range": {"x": "int16", "variance": "int16"},
    "acme_msgs/Hands": {"z": "int16", "one": "other_msgs/Limb"},
    "acme_msgs/Scan": {"one": "acme_msgs/Range"},
    "other_msgs/Limb": {"left": "int16", "right": "int16"},
    "other_msgs/Arm": {"left": "int16", "right": "int16"},
    "other_msgs/ArmPair": {"first": "other_msgs/SignalMsg", "all": "sequence<other_msgs/Arm>"},
    "other_msgs/SignalMsg": {"y": "int16"},
    "other_msgs/ImuData": {"z": "int16"},
    "other_msgs/IMUData": {"z": "int16"},
}
ARM = {"ros1": "acme_msgs/Arm", "ros2": "acme_msgs/msg/Arm"}
CROSSED = {"left": "right", "right": "left"}
LIMB = {**ARM, "ros2": "other_msgs/msg/Limb"}
BUILTIN = """mappings:
  - {ros1: acme_msgs/Range, ros2: acme_msgs/msg/Range, left_out: {ros2: [variance]}}
"""


@pytest.fixture
def registry(monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path) -> Callable[..., Any]:
    """Give a maker of registries."""
    share, folder = tmp_path / "share" / "ros2_bridge", tmp_path / "src" / "acme_msgs" / "msg"
    config = tmp_path / "src" / "ros2_bridge" / "config"
    for place in (share, folder, config):
        place.mkdir(parents=True)
    (share / "names.yaml").write_text("{}")
    (config / "mappings.yaml").write_text(BUILTIN)
    for package in ("acme_msgs", "ros2_bridge"):
        text = f"<package format='2'><name>{package}</name></package>"
        (tmp_path / "src" / package / "package.xml").write_text(text)
    for name, text in ROS1.items():
        (folder / f"{name}.msg").write_text(text)
    packages = rospkg.RosPack(ros_paths=[str(tmp_path / "src")])
    monkeypatch.setattr(rospkg, "RosPack", lambda: packages)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    for datatype, fields in ROS2.items():
        package, _, base = datatype.partition("/")
        for name in (package, f"{package}.msg"):
            if name not in sys.modules:
                monkeypatch.setitem(sys.modules, name, new_module(name))
        monkeypatch.setattr(
            sys.modules[f"{package}.msg"], base, new_class(package, base, fields), raising=False
        )
    return TypeRegistry


def new_module(name: str) -> types.ModuleType:
    module = types.ModuleType(name)
    module.__spec__ = types.SimpleNamespace(name=name)  # type: ignore[assignment]
    return module


def new_class(package: str, base: str, fields: Dict[str, str]) -> type:
    attributes = {
        "__module__": f"{package}.msg._{base.lower()}",
        "get_fields_and_field_types": staticmethod(lambda: fields),
    }
    return type(base, (), attributes)


def test_rule_for_a_type_holds_inside_a_type_with_the_same_names_in_both(
    registry: Callable[..., Any],
) -> None:
    data = struct.pack("<hhIhh", 1, 2, 1, 3, 4)
    same = registry([]).message("acme_msgs/Arms").codec.to_cdr(data)
    crossed = registry([{**ARM, "fields": CROSSED}]).message("acme_msgs/Arms").codec
    assert crossed.to_cdr(data) == same[:4] + struct.pack("<hhIhh", 2, 1, 1, 4, 3)
    assert crossed.to_ros1(crossed.to_cdr(data)) == data


def test_rule_for_another_type_leaves_the_type_that_contains_its_namesake(
    registry: Callable[..., Any],
) -> None:
    types_ = registry([{**LIMB, "fields": CROSSED}])
    data = struct.pack("<hhIhh", 1, 2, 1, 3, 4)
    kind = types_.message("acme_msgs/Arms")
    assert kind.codec.to_cdr(data) == registry([]).message("acme_msgs/Arms").codec.to_cdr(data)


def test_rule_for_another_type_holds_inside_a_type_with_that_in_ros2(
    registry: Callable[..., Any],
) -> None:
    data = struct.pack("<hhh", 1, 2, 3)
    codec = registry([{**LIMB, "fields": CROSSED}]).message("acme_msgs/Hands").codec
    assert codec.to_cdr(data)[4:] == struct.pack("<hhh", 1, 3, 2)


def test_rule_takes_precedence_over_the_name_that_make_environment_gave(
    registry: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    names = tmp_path / "share" / "ros2_bridge" / "names.yaml"
    names.write_text("{acme_msgs/Arm: other_msgs/Arm, acme_msgs/imu_data: other_msgs/IMUData}")
    types_ = registry([LIMB])
    assert types_.ros2_name("msg", "acme_msgs/Arm") == "other_msgs/Limb"
    assert types_.ros2_name("msg", "acme_msgs/imu_data") == "other_msgs/IMUData"
    assert types_.ros2_name("msg", "acme_msgs/arm_pair") == "acme_msgs/ArmPair"


def test_ros2_type_whose_namesake_has_another_counterpart_is_not_bridged(
    registry: Callable[..., Any],
) -> None:
    types_ = registry([LIMB])
    assert types_.message("acme_msgs/Arm").ros2 == "other_msgs/Limb"
    assert types_.ros1_name("other_msgs/msg/Limb") == "acme_msgs/Arm"
    with pytest.raises(Unbridgeable, match="acme_msgs/msg/Arm: a mapping rule gives its"):
        types_.message(types_.ros1_name("acme_msgs/msg/Arm"))


def test_rule_for_packages_that_are_not_installed_is_refused(registry: Callable[..., Any]) -> None:
    registry([{"ros1": "acme_msgs", "ros2": "other_msgs"}])
    with pytest.raises(MappingRuleError) as caught:
        registry([{"ros1": "acme_msg", "ros2": "other_msg"}])
    assert "package acme_msg is not installed in ROS 1" in str(caught.value)
    assert "package other_msg is not installed in ROS 2" in str(caught.value)
    imu = {"ros1": "acme_msgs/Imu", "ros2": "other_msgs/msg/ImuData"}
    with pytest.raises(MappingRuleError, match="type acme_msgs/Imu is not installed in ROS 1"):
        registry([LIMB, imu])


@pytest.mark.parametrize(
    ("fields", "rules", "why"),
    [
        (
            {"left": "int16", "wide": "int16"},
            [],
            "acme_msgs/Arm differs between ROS 1 and ROS 2: acme_msgs/Arm has field right in ROS 1",
        ),
        (
            {"left": "int16"},
            [{**ARM, "fields": {"left": "left"}}],
            "acme_msgs/Arm: its mapping rule does not fit: acme_msgs/Arm: right has no counterpart",
        ),
        (
            {"left": "wstring", "right": "int16"},
            [ARM],
            "acme_msgs/Arm: left: ROS 1 has no type wstring",
        ),
    ],
)
def test_type_that_differs_is_not_bridged_with_the_reason(
    registry: Callable[..., Any],
    monkeypatch: "pytest.MonkeyPatch",
    fields: Dict[str, str],
    rules: Any,
    why: str,
) -> None:
    other = new_class("acme_msgs", "Arm", fields)
    monkeypatch.setattr(sys.modules["acme_msgs.msg"], "Arm", other)
    with pytest.raises((Unbridgeable, MappingRuleError)) as caught:
        registry(rules).message("acme_msgs/Arm")
    assert why in str(caught.value)


def test_malformed_definition_is_not_bridged_with_the_error(
    registry: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    (tmp_path / "src" / "acme_msgs" / "msg" / "Arm.msg").write_text("int16\n")
    with pytest.raises(
        Unbridgeable, match=r"^type acme_msgs/Arm is not installed in ROS 1 \(.+\)$"
    ):
        registry().message("acme_msgs/Arm")


def test_missing_type_is_searched_once(registry: Callable[..., Any]) -> None:
    types_, searched = registry([]), []

    def fail(name: str) -> None:
        searched.append(name)
        raise Unbridgeable(f"{name} is missing")

    types_._make_message = fail
    for _ in range(2):  # as each poll asks for it
        with pytest.raises(Unbridgeable, match="acme_msgs/Nothing is missing"):
            types_.message("acme_msgs/Nothing")
    assert searched == ["acme_msgs/Nothing"]


def test_rule_for_a_package_pairs_names_with_their_camel_case(
    registry: Callable[..., Any],
) -> None:
    types_ = registry([{"ros1": "acme_msgs", "ros2": "other_msgs"}])
    signal = types_.message("acme_msgs/signal_msg")
    assert signal.ros2 == "other_msgs/SignalMsg"
    assert types_.ros1_name("other_msgs/msg/SignalMsg") == "acme_msgs/signal_msg"
    pair = types_.message("acme_msgs/arm_pair")
    assert pair.ros2 == "other_msgs/ArmPair"
    data = struct.pack("<hIhh", 7, 1, 3, 4)
    assert pair.codec.to_ros1(pair.codec.to_cdr(data)) == data


def test_ambiguous_name_in_a_renamed_package_is_not_bridged(
    registry: Callable[..., Any],
) -> None:
    types_ = registry([{"ros1": "acme_msgs", "ros2": "other_msgs"}])
    with pytest.raises(Unbridgeable, match="the names imu_data, IMUData, ImuData differ only"):
        types_.message("acme_msgs/imu_data")
    imu = {"ros1": "acme_msgs/imu_data", "ros2": "other_msgs/msg/ImuData"}
    types_ = registry([{"ros1": "acme_msgs", "ros2": "other_msgs"}, imu])
    assert types_.message("acme_msgs/imu_data").ros2 == "other_msgs/ImuData"


def test_candidates_are_the_types_of_shared_packages_and_of_the_rules(
    registry: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    index = tmp_path / "share" / "ament_index" / "resource_index" / "rosidl_interfaces"
    index.mkdir(parents=True)
    (index / "other_msgs").touch()
    assert registry([]).candidates() == []
    assert registry([LIMB]).candidates() == [("msg", "acme_msgs/Arm")]
    renamed = {"ros1": "acme_msgs", "ros2": "other_msgs"}
    every = [("msg", f"acme_msgs/{name}") for name in sorted(ROS1)]
    assert registry([renamed]).candidates() == every
    assert registry([renamed, LIMB]).candidates() == every
    (index / "acme_msgs").touch()
    assert registry([]).candidates() == every


def test_draft_for_a_type_with_a_rule_of_the_bridge_replaces_that_rule(
    registry: Callable[..., Any],
) -> None:
    draft = registry().draft("acme_msgs/Range", "acme_msgs/msg/Range")
    assert draft["left_out"] == {"ros1": [], "ros2": ["variance"]}


def test_draft_leaves_out_no_field_that_a_rule_of_the_bridge_assigns(
    registry: Callable[..., Any],
) -> None:
    draft = registry().draft("acme_msgs/Scan", "acme_msgs/msg/Scan")
    assert draft["left_out"] == {"ros1": ["seq"], "ros2": []}


def test_draft_for_a_service_has_the_fields_of_both_parts(
    registry: Callable[..., Any], monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    folder = tmp_path / "src" / "acme_msgs" / "srv"
    folder.mkdir()
    (folder / "Ask.srv").write_text("int16 x\nint16 old\n---\nint16 y\n")
    parts = {"Request": {"x": "int16"}, "Response": {"y": "int16", "new": "int16"}}
    ask = types.SimpleNamespace(
        **{part: new_class("acme_msgs", f"Ask_{part}", fields) for part, fields in parts.items()}
    )
    monkeypatch.setitem(sys.modules, "acme_msgs.srv", new_module("acme_msgs.srv"))
    monkeypatch.setattr(sys.modules["acme_msgs.srv"], "Ask", ask, raising=False)
    draft = registry().draft("acme_msgs/Ask", "acme_msgs/srv/Ask")
    assert draft["left_out"] == {"ros1": ["request.old"], "ros2": ["response.new"]}


def test_draft_for_packages_or_without_a_ros2_type_is_refused(
    registry: Callable[..., Any], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    with pytest.raises(MappingRuleError, match="a draft is of a rule for types"):
        registry().draft("acme_msgs", "other_msgs")
    monkeypatch.setattr(sys.modules["other_msgs.msg"].Limb, "_md5sum", "*", raising=False)
    with pytest.raises(Unbridgeable, match="other_msgs/msg/Limb is not installed in ROS 2"):
        registry().draft("acme_msgs/Arm", "other_msgs/msg/Limb")


@pytest.mark.parametrize("left_out", ["acme_msgs/msg/imu_data.msg", "acme_msgs"])
def test_missing_type_is_named_with_the_reason_of_make_environment(
    registry: Callable[..., Any], tmp_path: pathlib.Path, left_out: str
) -> None:
    (tmp_path / "share" / "ros2_bridge" / "left_out.yaml").write_text(f"{left_out}: 'no: z'\n")
    with pytest.raises(Unbridgeable) as caught:
        registry().message("acme_msgs/imu_data")
    missing = "acme_msgs/imu_data needs acme_msgs/msg/ImuData, which is not installed in ROS 2"
    assert str(caught.value) == f"{missing} (no: z)"
