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
from ros2_bridge.types.type_registry import TypeRegistry, Unbridgeable, package_folder

PACKAGES = (
    "std_msgs std_srvs geometry_msgs nav_msgs sensor_msgs diagnostic_msgs rosgraph_msgs tf2_msgs"
    " actionlib_msgs visualization_msgs"
)
#: Types that differ: they are not bridged, with a log line.
MARKERS = "Marker MarkerArray InteractiveMarker InteractiveMarkerControl InteractiveMarkerInit"
DIFFERENT = {"sensor_msgs/Range", "visualization_msgs/InteractiveMarkerUpdate"}
DIFFERENT.update(f"visualization_msgs/{name}" for name in MARKERS.split())
#: Types that differ in ROS 2: actions, and those of its tf2.
OLD = re.compile(
    "Action|Goal$|Result$|Feedback$|TF2Error|FrameGraph|rosgraph_msgs/(Log|TopicStatistics)"
)
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
    """Fill a message of ROS 2 with anything."""
    for name, kind in message.get_fields_and_field_types().items():
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
    if name in DIFFERENT:
        with pytest.raises(Unbridgeable, match="differs between ROS 1 and ROS 2: .* has field"):
            TypeRegistry().message(name)
        return
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
