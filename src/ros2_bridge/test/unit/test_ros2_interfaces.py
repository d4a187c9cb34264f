"""The ROS 2 twins of message packages, as text."""

from typing import Dict

import pytest

from ros2_bridge.types.ros2_interfaces import (
    Interfaces,
    TwinPackage,
    generate_interfaces,
    twin_type,
)


def interfaces(**definitions: Dict[str, str]) -> Interfaces:
    """Return the twins of packages, in addition to ROS 2's own messages."""
    own = ("std_msgs", "builtin_interfaces", "geometry_msgs")
    return generate_interfaces(definitions, lambda message: message.partition("/")[0] in own)


def twins_of(definitions: Dict[str, str]) -> TwinPackage:
    """Return the twins of a package that ROS 2 supports completely."""
    packages, left_out = interfaces(pkg=definitions)
    assert left_out == {}
    return packages["pkg"]


@pytest.mark.parametrize(
    "name, twin",
    [
        ("basic_comms/signal_msg", "basic_comms/SignalMsg"),
        ("basic_comms/SignalMsg", "basic_comms/SignalMsg"),
        ("pkg/my_2nd_type", "pkg/My2ndType"),
        ("pkg/my_IMU_type", "pkg/MyIMUType"),
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
        "string FOLDER=C:\\tmp\n"
        "Header header\n"
        "time[2]  when   # twice\n"
        "float64[9] K\n"
        "inner_one[] inner\n"
        "geometry_msgs/Point place\n"
    )
    twin = twins_of({"msg/outer_one.msg": text, "msg/inner_one.msg": "int8 x\n"})
    assert twin.files["msg/OuterOne.msg"] == (
        "# What it is.\n"
        "uint8 SMALL=3\n"
        'string GREETING="say \\"hi\\" # twice"\n'
        'string FOLDER="C:\\\\tmp"\n'
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
    twin = twins_of({"srv/Ask.srv": "bool enable\n---\nstring message\n"})
    assert twin.files["srv/Ask.srv"] == "bool enable\n---\nstring message\n"
    assert '"srv/Ask.srv"' in twin.files["CMakeLists.txt"]  # which builds it


@pytest.mark.parametrize(
    "text, reason",
    [
        ("int32 trailing_\n", "trailing_ is not a valid name of a field or constant in ROS 2"),
        ("int32 a__b\n", "a__b is not a valid name of a field or constant in ROS 2"),
        ("int32 long\n", "long is not a valid name of a field or constant in ROS 2"),
        ("int32 X\nint32 x\n", "X and x are both x in ROS 2"),
        ("int32 FOO=1\nint32 foo=2\n", "FOO and foo are both FOO in ROS 2"),
        ("int32\n", "'int32' is not a field of a message"),
        ("other_msgs/Odd odd\n", "it uses other_msgs/Odd, which ROS 2 does not have here"),
    ],
)
def test_unsupported_type_is_skipped_with_its_users(text: str, reason: str) -> None:
    packages, left_out = interfaces(
        pkg={"msg/Odd.msg": text, "msg/Good.msg": "int8 x\n", "srv/Ask.srv": "Odd odd\n---\n"},
        pkg_user={"msg/A.msg": "pkg/Odd[] odd\n", "msg/B.msg": "pkg/Good good\n"},
    )
    assert [path for path in packages["pkg"].files if "/" in path] == ["msg/Good.msg"]
    assert [path for path in packages["pkg_user"].files if "/" in path] == ["msg/B.msg"]
    user = "it uses pkg/Odd, which ROS 2 does not have here"
    assert left_out == {
        "pkg/msg/Odd.msg": reason,
        "pkg/srv/Ask.srv": user,
        "pkg_user/msg/A.msg": user,
    }


#: Keywords of C11 and C++17 in lower case, and some of Python.
KEYWORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const
const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit
export extern false float for friend goto if inline int long mutable namespace new noexcept not
not_eq nullptr operator or or_eq private protected public register reinterpret_cast restrict return
short signed sizeof static static_assert static_cast struct switch template this thread_local throw
true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq
lambda yield
""".split()


@pytest.mark.parametrize("word", KEYWORDS)
def test_field_with_the_name_of_a_keyword_is_left_out(word: str) -> None:
    left_out = interfaces(pkg={"msg/A.msg": f"int32 {word}\n"}).left_out
    reason = f"{word} is not a valid name of a field or constant in ROS 2"
    assert left_out == {"pkg/msg/A.msg": reason}


def test_request_and_response_may_share_field_names() -> None:
    twin = twins_of({"srv/Ask.srv": "int8 x\n---\nint8 X\n"})
    assert twin.files["srv/Ask.srv"] == "int8 x\n---\nint8 x\n"


def test_service_is_not_taken_for_a_message_of_its_name() -> None:
    _, left_out = interfaces(pkg={"msg/A.msg": "Ask ask\n", "srv/Ask.srv": "---\n"})
    assert left_out == {"pkg/msg/A.msg": "it uses pkg/Ask, which ROS 2 does not have here"}


def test_second_type_with_the_same_name_in_ros2_is_left_out() -> None:
    packages, left_out = interfaces(pkg={"msg/my_type.msg": "", "msg/MyType.msg": ""})
    assert left_out == {"pkg/msg/my_type.msg": "pkg/msg/MyType.msg is pkg/MyType in ROS 2 already"}
    assert packages["pkg"].names == {}


def test_package_without_any_twin_is_left_out() -> None:
    assert interfaces(pkg={"msg/A.msg": "int32 long\n"}).packages == {}


def test_action_has_three_parts_and_dependencies() -> None:
    text = "float64 Far\n---\nstd_msgs/Header header\n---\nfloat64 left\n"
    twin = twins_of({"action/go_to.action": text})
    assert twin.files["action/GoTo.action"] == (
        "float64 far\n---\nstd_msgs/Header header\n---\nfloat64 left\n"
    )
    assert twin.names == {"pkg/go_to": "pkg/GoTo"}
    assert twin.needs == {"action_msgs", "std_msgs", "unique_identifier_msgs"}
    assert '"action/GoTo.action"' in twin.files["CMakeLists.txt"]
