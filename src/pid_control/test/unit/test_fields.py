"""Tests of numeric message fields."""

import pytest
from geometry_msgs.msg import TwistStamped
from std_msgs.msg import Float64MultiArray, Int32

from pid_control.msg import motor_input
from pid_control.recording.fields import Field, FieldError, field_of, number_in, put_number

TOPICS = ["/motor", "/motor/input", "/other"]


def test_field_of_prefers_the_longest_topic() -> None:
    assert field_of("/motor/input/data", TOPICS) == Field("/motor/input", "data")
    assert field_of("motor/speed", TOPICS) == Field("/motor", "speed")
    assert str(field_of("motor/input/a/b/", TOPICS)) == "/motor/input/a/b"
    for topics, names in ((reversed(TOPICS), "/motor, /motor/input, /other"), ([], "none")):
        with pytest.raises(FieldError) as error:
            field_of("/motors/x", list(topics))
        assert str(error.value) == f"/motors/x: unknown topic; choose one of: {names}"


def test_number_is_found_at_any_depth() -> None:
    twist = TwistStamped()
    twist.twist.linear.x = 3.0
    assert number_in(twist, Field("/a", "twist/linear/x")) == 3.0
    assert number_in(twist, Field("/a", "header/seq")) == 0.0
    two = Float64MultiArray(data=[1.0, 2.0])
    assert number_in(two, Field("/a", "data[1]")) == 2.0
    with pytest.raises(FieldError, match=r"'data\[2\]' is not an element of an array"):
        number_in(two, Field("/a", "data[2]"))


@pytest.mark.parametrize(
    "path, why",
    [
        ("twist/linear", "/a/twist/linear is not a number; it has: x, y, z"),
        ("twist/speed", "/a/twist/speed: unknown field 'speed'; it has: linear, angular"),
        ("__class__", "/a/__class__: unknown field '__class__'; it has: header, twist"),
        ("header/frame_id", "/a/header/frame_id is not a number"),
        ("header[0]", "/a/header[0]: 'header[0]' is not an element of an array"),
        ("header/seq/x", "/a/header/seq/x: unknown field 'x'"),
        ("", "/a/: unknown field ''; it has: header, twist"),
    ],
)
def test_number_in_invalid_field_names_the_problem(path: str, why: str) -> None:
    with pytest.raises(FieldError) as error:
        number_in(TwistStamped(), Field("/a", path))
    assert str(error.value) == why


def test_put_number_sets_the_field() -> None:
    message, twist, whole = motor_input(), TwistStamped(), Int32()
    put_number(whole, Field("/a", "data"), 2.6)
    assert whole.data == 2 and isinstance(whole.data, int)
    put_number(message, Field("/a", "input"), 0.5)
    put_number(twist, Field("/a", "twist/angular/z"), 2.0)
    assert (message.input, twist.twist.angular.z) == (0.5, 2.0)
    with pytest.raises(FieldError, match="an element cannot be set"):
        put_number(Float64MultiArray(data=[1.0]), Field("/a", "data[0]"), 1.0)
    with pytest.raises(FieldError, match="unknown field 'speed'"):
        put_number(message, Field("/a", "speed"), 1.0)
