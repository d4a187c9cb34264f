"""The ROS 2 twins of message packages, as text."""

from typing import Dict

import pytest

from nodekit.message_definitions import DefinitionError
from ros2_bridge.types.ros2_interfaces import generate_interfaces, twin_type


@pytest.mark.parametrize(
    "name, twin",
    [
        ("basic_comms/signal_msg", "basic_comms/SignalMsg"),
        ("basic_comms/SignalMsg", "basic_comms/SignalMsg"),
        ("pkg/my_2nd_type", "pkg/My2ndType"),
        ("std_msgs/Time", "builtin_interfaces/Time"),
        ("duration", "builtin_interfaces/Duration"),
        ("uint8", "uint8"),
    ],
)
def test_type_is_camel_case(name: str, twin: str) -> None:
    assert twin_type(name) == twin


def test_definition_is_written_as_ros2_wants_it() -> None:
    text = (
        "# What it is.\n"
        "uint8 small = 3 # three\n"
        'string GREETING=say "hi" # twice\n'
        "Header header\n"
        "time[2]  when   # twice\n"
        "float64[9] K\n"
        "inner_one[] inner\n"
        "geometry_msgs/Point place\n"
    )
    twin = generate_interfaces("pkg", {"msg/outer_one.msg": text, "msg/inner_one.msg": "int8 x\n"})
    assert twin.files["msg/OuterOne.msg"] == (
        "# What it is.\n"
        "uint8 SMALL=3\n"
        'string GREETING="say \\"hi\\" # twice"\n'
        "std_msgs/Header header\n"
        "builtin_interfaces/Time[2] when  # twice\n"
        "float64[9] k\n"
        "pkg/InnerOne[] inner\n"
        "geometry_msgs/Point place\n"
    )
    assert twin.needs == {"std_msgs", "builtin_interfaces", "geometry_msgs"}
    assert twin.names == {"pkg/outer_one": "pkg/OuterOne", "pkg/inner_one": "pkg/InnerOne"}
    cmake = twin.files["CMakeLists.txt"]
    assert '"msg/InnerOne.msg"\n  "msg/OuterOne.msg"' in cmake
    assert "find_package(geometry_msgs REQUIRED)" in cmake
    assert "<depend>geometry_msgs</depend>" in twin.files["package.xml"]


def test_service_keeps_the_line_between_request_and_answer() -> None:
    twin = generate_interfaces("pkg", {"srv/Ask.srv": "bool enable\n---\nstring message\n"})
    assert twin.files["srv/Ask.srv"] == "bool enable\n---\nstring message\n"


@pytest.mark.parametrize(
    "definitions, words",
    [
        ({"msg/A.msg": "int32 trailing_\n"}, "pkg/msg/A.msg: trailing_ is not a legal name"),
        ({"msg/A.msg": "int32\n"}, "'int32' is not a field"),
        ({"msg/my_type.msg": "", "msg/MyType.msg": ""}, "another type is pkg/MyType"),
    ],
)
def test_what_has_no_twin_is_refused(definitions: Dict[str, str], words: str) -> None:
    with pytest.raises(DefinitionError, match=words.replace("/", ".")):
        generate_interfaces("pkg", definitions)


def test_action_has_three_parts_and_what_ros2_needs_for_them() -> None:
    text = "float64 Far\n---\nstd_msgs/Header header\n---\nfloat64 left\n"
    twin = generate_interfaces("pkg", {"action/go_to.action": text})
    assert twin.files["action/GoTo.action"] == (
        "float64 far\n---\nstd_msgs/Header header\n---\nfloat64 left\n"
    )
    assert twin.names == {"pkg/go_to": "pkg/GoTo"}
    assert twin.needs == {"action_msgs", "std_msgs", "unique_identifier_msgs"}
    assert '"action/GoTo.action"' in twin.files["CMakeLists.txt"]
