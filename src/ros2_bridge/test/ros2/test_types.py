"""The codec compared with both ROSes' serialization, for every type that both have."""

import importlib
import io
import pathlib
import random
import re
import sys
from types import SimpleNamespace
from typing import Any, List

import genpy.dynamic
import pytest
import rospkg
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from unique_identifier_msgs.msg import UUID

from ros2_bridge.actions.status_list import ListedGoal, read_list, write_list
from ros2_bridge.types.mapping_rules import MappingRuleError
from ros2_bridge.types.definition_folders import package_folder
from ros2_bridge.types.type_registry import TypeRegistry, Unbridgeable

PACKAGES = (
    "std_msgs std_srvs geometry_msgs nav_msgs sensor_msgs diagnostic_msgs rosgraph_msgs tf2_msgs"
    " actionlib_msgs visualization_msgs"
)
#: Fields that ROS 1 lacks, by ROS 2 type: the bridge's own mapping rules leave them out.
LEFT_OUT = {
    "Range": ("variance",),
    "Marker": ("texture_resource", "texture", "uv_coordinates", "mesh_file"),
}
#: Types that differ in ROS 2: actions, and those of its tf2.
OLD = re.compile(
    "Action|Goal$|Result$|Feedback$|TF2Error|FrameGraph|rosgraph_msgs/(Log|TopicStatistics)"
)
PARTS_OF_A_POSE = (("position", "xyz"), ("orientation", "xyzw"))
TIMES = {"sec": 2**31, "nanosec": 10**9}
INTEGERS = {"int8": 8, "uint8": 8, "octet": 8, "int16": 16, "uint16": 16, "int32": 32}
INTEGERS.update({"uint32": 32, "int64": 64, "uint64": 64})


def names(kind: str) -> List[str]:
    sources = pathlib.Path(__file__).resolve().parents[3]
    packages = PACKAGES.split() + [path.parent.name for path in sources.glob("*/package.xml")]
    found = []
    for package in packages:
        place = package_folder(rospkg.RosPack(), package)
        assert place is not None, package
        found += [f"{package}/{path.stem}" for path in sorted(place.glob(f"{kind}/*.{kind}"))]
    return [name for name in found if not OLD.search(name)]


def fill(message: Any, chance: random.Random) -> Any:
    """Fill a message of ROS 2 with anything, apart from the fields that are left out."""
    for name, kind in message.get_fields_and_field_types().items():
        if name in LEFT_OUT.get(type(message).__name__, ()):
            continue
        if name in TIMES:  # what a time of ROS 1 can be
            setattr(message, name, chance.randrange(TIMES[name]))
        else:
            setattr(message, name, value(kind, chance))
    return message


def value(kind: str, chance: random.Random) -> Any:
    if kind.startswith("sequence<"):
        inner = kind[len("sequence<") : -1].partition(",")[0]
        return several(inner, chance.randrange(4), chance)
    if kind.endswith("]"):
        inner, _, count = kind[:-1].partition("[")
        return several(inner, int(count), chance)
    if kind == "boolean":
        return chance.random() < 0.5
    if kind == "octet":
        return bytes([chance.randrange(256)])
    if kind in INTEGERS:
        low = 0 if kind.startswith("u") else -(2 ** (INTEGERS[kind] - 1))
        return chance.randrange(low, low + 2 ** INTEGERS[kind])
    if kind in ("float", "double"):
        return float(chance.randrange(-1000, 1000)) / 8.0
    if kind == "string":
        return "".join(chance.choice("aß€ z") for _ in range(chance.randrange(6)))
    package, _, base = kind.partition("/")
    return fill(getattr(importlib.import_module(f"{package}.msg"), base)(), chance)


def several(kind: str, count: int, chance: random.Random) -> Any:
    return [value(kind, chance) for _ in range(count)]


def check(codec: Any, cls: Any, name: str, genpy_class: Any = None) -> None:
    chance = random.Random(name)
    for _ in range(4):
        message = fill(cls(), chance)
        cdr = serialize_message(message)
        ros1 = codec.to_ros1(cdr)
        # Not by their bytes: rclpy leaves in its padding what has been there before.
        assert deserialize_message(codec.to_cdr(ros1), cls) == message
        if genpy_class is not None:  # what genpy reads, it writes in the same way
            buffer = io.BytesIO()
            genpy_class().deserialize(ros1).serialize(buffer)
            assert buffer.getvalue() == ros1


@pytest.mark.parametrize("name", names("msg"))
def test_message_is_the_same_in_both(name: str) -> None:
    kind = TypeRegistry().message(name)
    classes = genpy.dynamic.generate_dynamic(name, kind.raw._full_text)
    check(kind.codec, kind.cls, name, classes[name])


@pytest.mark.parametrize("name", names("srv"))
def test_service_is_the_same_in_both(name: str) -> None:
    kind = TypeRegistry().service(name)
    check(kind.request, kind.cls.Request, name)
    check(kind.response, kind.cls.Response, name)


@pytest.mark.parametrize("name", ["visualization_msgs/Marker", "bot_controller_demo_msgs/GoToGoal"])
def test_ros1_only_type_is_reported_missing_in_ros2(
    name: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    package, _, base = name.partition("/")
    of_ros1 = SimpleNamespace(Marker=type("Marker", (), {"_md5sum": ""}))
    monkeypatch.setitem(sys.modules, "visualization_msgs.msg", of_ros1)
    with pytest.raises(Unbridgeable) as caught:
        TypeRegistry().message(name)
    missing = f"{name} needs {package}/msg/{base}, which is not installed in ROS 2"
    assert str(caught.value) == missing


@pytest.mark.parametrize("count", [0, 1, 2, 50])
def test_list_of_goals_is_ros2s_own(count: int) -> None:
    goals = [ListedGoal(bytes([n]) * 16, n * 10**9 + 7, n % 7) for n in range(count)]
    listed = [
        GoalStatus(
            goal_info=GoalInfo(goal_id=UUID(uuid=list(uuid)), stamp=Time(sec=n, nanosec=7)),
            status=status,
        )
        for n, (uuid, _, status) in enumerate(goals)
    ]
    message = GoalStatusArray(status_list=listed)
    data = serialize_message(message)  # padding has arbitrary bytes
    assert read_list(data) == goals and len(write_list(goals)) == len(data)
    assert deserialize_message(write_list(goals), GoalStatusArray) == message


def test_message_without_a_counterpart_is_zero_or_has_the_default_of_ros2() -> None:
    kind = TypeRegistry().message("sensor_msgs/Range")
    message = kind.cls(range=2.5, variance=0.5)
    back = deserialize_message(
        kind.codec.to_cdr(kind.codec.to_ros1(serialize_message(message))), kind.cls
    )
    assert (back.range, back.variance) == (2.5, 0.0)


#: Of the test's own: a pose becomes a transform, whose rotation's default is not zero in ROS 2.
POSE = {
    "ros1": "geometry_msgs/PoseStamped",
    "ros2": "geometry_msgs/msg/TransformStamped",
    "fields": {"pose.position": "transform.translation"},
    "left_out": {"ros1": ["pose.orientation"], "ros2": ["child_frame_id", "transform.rotation"]},
}


def test_rule_of_the_user_assigns_fields_both_ways() -> None:
    types = TypeRegistry([POSE])
    kind = types.message("geometry_msgs/PoseStamped")
    assert kind.ros2 == "geometry_msgs/TransformStamped"
    assert types.ros1_name("geometry_msgs/msg/TransformStamped") == "geometry_msgs/PoseStamped"
    classes = genpy.dynamic.generate_dynamic(kind.ros1, kind.raw._full_text)
    pose = classes[kind.ros1]()
    pose.header.seq, pose.header.frame_id, pose.pose.position.y = 7, "map", 3.0
    pose.pose.orientation.x = 0.5
    buffer = io.BytesIO()
    pose.serialize(buffer)
    cdr = kind.codec.to_cdr(buffer.getvalue())
    transform = deserialize_message(cdr, kind.cls)
    assert (transform.header.frame_id, transform.transform.translation.y) == ("map", 3.0)
    assert (transform.transform.rotation.x, transform.transform.rotation.w) == (0.0, 1.0)
    back = classes[kind.ros1]().deserialize(kind.codec.to_ros1(cdr, 8))
    assert (back.header.seq, back.pose.position.y, back.pose.orientation.w) == (8, 3.0, 0.0)


@pytest.mark.parametrize(
    ("rule", "reason"),
    [
        ({**POSE, "fields": {}}, "pose.position.x has no counterpart pose.position.x in"),
        ({**POSE, "ros2": "geometry_msgs/msg/Nothing"}, "which is not installed in ROS 2"),
        ({**POSE, "ros1": "geometry_msgs/Nothing"}, "is not installed in ROS 1"),
        (
            {"ros1": "std_msgs/Int8", "ros2": "std_msgs/msg/Int8", "left_out": {"ros2": ["x"]}},
            "std_msgs/Int8 has no field x",
        ),
    ],
)
def test_rule_that_does_not_fit_its_types_is_refused(rule: Any, reason: str) -> None:
    with pytest.raises(MappingRuleError) as caught:
        TypeRegistry([rule])
    assert reason in str(caught.value)


def test_draft_of_a_rule_leaves_out_each_field_without_a_counterpart() -> None:
    draft = TypeRegistry().draft("geometry_msgs/PoseStamped", "geometry_msgs/msg/TransformStamped")
    numbers = [f"{part}.{axis}" for part, axes in PARTS_OF_A_POSE for axis in axes]
    theirs = [name.replace("position", "translation") for name in numbers]
    theirs = [name.replace("orientation", "rotation") for name in theirs]
    assert draft["left_out"] == {
        "ros1": [f"pose.{name}" for name in numbers],
        "ros2": ["child_frame_id", *(f"transform.{name}" for name in theirs)],
    }
    assert TypeRegistry([draft]).message(draft["ros1"]).ros2 == "geometry_msgs/TransformStamped"
    service = TypeRegistry().draft("std_srvs/SetBool", "std_srvs/srv/Trigger")
    assert service["left_out"] == {"ros1": ["request.data"], "ros2": []}
    kind = TypeRegistry([service]).service("std_srvs/SetBool")
    request = deserialize_message(kind.request.to_cdr(b"\1"), kind.cls.Request)
    assert request == kind.cls.Request()


def test_nested_message_of_the_same_name_is_not_taken_for_its_container() -> None:
    container = type("Pose", (), {"__module__": "acme_msgs.msg._pose"})
    found = TypeRegistry._class("geometry_msgs/Pose", container)
    assert found.get_fields_and_field_types() == {
        "position": "geometry_msgs/Point",
        "orientation": "geometry_msgs/Quaternion",
    }


def test_rule_for_an_action_concerns_its_parts() -> None:
    name = "bot_controller_demo_msgs/GoTo"
    paths = ["goal.target_pose.pose.position.z"]
    rule = {"ros1": name, "ros2": "bot_controller_demo_msgs/action/GoTo"}
    kind = TypeRegistry([{**rule, "left_out": {"ros1": paths, "ros2": paths}}]).action(name)
    goal = kind.cls.Goal()
    goal.target_pose.pose.position.y = goal.target_pose.pose.position.z = 2.0
    back = deserialize_message(
        kind.goal.to_cdr(kind.goal.to_ros1(serialize_message(goal))), kind.cls.Goal
    )
    assert (back.target_pose.pose.position.y, back.target_pose.pose.position.z) == (2.0, 0.0)
