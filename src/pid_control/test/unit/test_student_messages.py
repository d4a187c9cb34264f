"""Tests of the messages of a student's package."""

import os
import pathlib
import subprocess
import sys
from typing import Any, Dict
from unittest import mock

import pytest
import rospkg
from std_msgs.msg import Float32, String

from pid_control.msg import motor_output, set_point
from pid_control.programs.package_messages import MessageTypeError
from pid_control.programs.program_command import ProgramCommand
from pid_control.runner import student_messages
from pid_control.runner.loop_messages import (
    course_messages,
    loop_message,
    given_message,
)
from pid_control.runner.student_messages import StudentMessages, read_messages


def read(tmp_path: pathlib.Path, name: str, definitions: Dict[str, str]) -> StudentMessages:
    """Read the messages of a package with these definitions."""
    package = tmp_path / "package"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text(f"<package><name>{name}</name></package>")
    for message, text in definitions.items():
        (package / "msg" / f"{message}.msg").write_text(text)
    command = ProgramCommand("x", ["x"], {}, {}, {}, package=str(package))
    return read_messages(command, str(tmp_path / "scratch"))


@pytest.mark.parametrize("field", ["setpoint", "set_point", "value", "data", "reference"])
def test_own_set_point_is_followed_by_its_first_float(tmp_path: pathlib.Path, field: str) -> None:
    times = "float64 time\nfloat64 stamp\nfloat64 t\n"
    found = read(tmp_path, "pid_control", {"set_point": f"{times}float32 {field}\n"})
    message = found.by_topic["set_point"]
    assert (message.field, message.is_of_course) == (field, False)
    filled = message.filled(1.5, 2.0)
    assert (getattr(filled, field), filled.time, filled.stamp, filled.t) == (1.5, 2.0, 2.0, 2.0)
    assert list(found.command.notes) == [
        "motor_output.msg is empty or missing; the judge's is used",
        "motor_input.msg is empty or missing; the judge's is used",
        "set_point is pid_control/set_point with (float64 time, float64 stamp, float64 t, float32"
        f" {field}), in the course (float32 setPoint, float64 time); the field {field} is used",
    ]


def test_own_messages_have_the_definition_that_the_controller_imports(
    tmp_path: pathlib.Path,
) -> None:
    definitions = {"set_point": "float32 value\n", "motor_input": "float32 u\nfloat64 time\n"}
    found = read(tmp_path, "pid_control", definitions)
    program = "from pid_control.msg import set_point; print(set_point._md5sum, set_point().value)"
    path = f"{found.command.environment['PYTHONPATH']}:{':'.join(sys.path)}"
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={"PYTHONPATH": path},
        stdout=subprocess.PIPE,
        check=True,
        universal_newlines=True,
    )
    own: Any = found.by_topic["set_point"].message_class
    assert done.stdout.split() == [own._md5sum, "0.0"]
    assert own._md5sum != set_point._md5sum


def test_own_message_with_a_comment_that_is_not_utf8_is_used(tmp_path: pathlib.Path) -> None:
    read(tmp_path, "reto", {"set_point": "float32 q\n"})
    package, scratch = tmp_path / "package", str(tmp_path / "again")
    (package / "msg" / "set_point.msg").write_bytes(b"float32 r  # Gr\xf6\xdfe\n")
    command = ProgramCommand("x", ["x"], {}, {}, {}, package=str(package))
    assert read_messages(command, scratch).by_topic["set_point"].field == "r"


def test_empty_set_point_of_the_template_is_that_of_the_course(tmp_path: pathlib.Path) -> None:
    found = read(tmp_path, "pid_control", {"set_point": "\n"})
    assert all(message.is_of_course for message in found.by_topic.values())
    notes = " ".join(found.command.notes)
    assert "set_point.msg is empty or missing; the judge's is used" in notes


def test_package_of_another_name_has_its_own_types(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    packages = mock.Mock(ResourceNotFound=rospkg.ResourceNotFound)
    packages.RosPack.return_value.get_path.side_effect = rospkg.ResourceNotFound("pid_control")
    monkeypatch.setattr(student_messages, "rospkg", packages)
    found = read(tmp_path, "reto", {"set_point": "float32 r\n", "Other": "string text\n"})
    assert found.by_topic["set_point"].message_class._type == "reto/set_point"
    assert found.by_topic["motor_output"].is_of_course


@pytest.mark.parametrize("name", ["../../evil", "/tmp/evil", "my-package", "a b", "2dof"])
def test_package_with_an_illegal_name_is_refused(tmp_path: pathlib.Path, name: str) -> None:
    with pytest.raises(MessageTypeError, match=f"<name> must be letters.*'{name}'"):
        read(tmp_path / "a", name, {"set_point": "float32 r\n"})
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["package"]


def test_package_without_messages_or_with_invalid_ones_has_those_of_the_course(
    tmp_path: pathlib.Path,
) -> None:
    point = {"set_point": "float32 r\n"}
    for name, own, definitions in (("a", "reto", {}), ("b", "", point)):
        found = read(tmp_path / name, own, definitions)
        assert found == StudentMessages(found.command, {}, course_messages())
        assert (found.command.name, list(found.command.notes)) == ("x", [])
    found = read(tmp_path / "c", "reto", {"set_point": "no_such_type x y\n"})
    assert found.by_topic == course_messages()
    assert list(found.command.notes) == ["the messages of reto cannot be generated"]


def test_message_without_a_float_names_its_fields(tmp_path: pathlib.Path) -> None:
    says = r"set_point: std_msgs/String has no float field; its fields are: string data"
    with pytest.raises(MessageTypeError, match=says):
        loop_message("set_point", String)


def test_time_of_a_message_of_the_first_coursework_is_not_its_value(tmp_path: pathlib.Path) -> None:
    found = read(tmp_path, "reto", {"set_point": "float32 time_x\nfloat32 signal_y\n"})
    filled = found.by_topic["set_point"].filled(5.0, 1.5)
    assert (filled.time_x, filled.signal_y) == (1.5, 5.0)


def test_messages_come_first_and_fields_of_other_types_are_left(tmp_path: pathlib.Path) -> None:
    """The course's own definition needs no note."""
    course = "float32 setPoint\nfloat64 time\n"
    odd = "float32 v\nint32 status\ntime stamp\n"
    found = read(tmp_path, "reto", {"set_point": course, "motor_output": odd})
    assert not any("set_point" in note for note in found.command.notes)
    filled = found.by_topic["motor_output"].filled(1.5, 2.0, "Motor Turning")
    assert (filled.v, filled.status, filled.stamp.to_sec()) == (1.5, 0, 0.0)
    given = given_message("motor_output", "reto/motor_output", found.classes)
    assert given.message_class is found.classes["reto/motor_output"]
    environment = {"PYTHONPATH": "/before"}
    command = ProgramCommand("x", ["x"], environment, {}, {}, package=str(tmp_path / "package"))
    again = read_messages(command, str(tmp_path / "again"))
    path = again.command.environment["PYTHONPATH"]
    assert path == f"{tmp_path / 'again'}{os.pathsep}/before"


def test_given_type_and_field_are_used() -> None:
    message = given_message("set_point", "std_msgs/Float32/data", {})
    assert (message.message_class, message.field) == (Float32, "data")
    assert message.filled(2.5, 1.0).data == 2.5
    assert given_message("motor_output", "pid_control/motor_output", {}).field == "output"


@pytest.mark.parametrize(
    "text, says",
    [
        ("Float32", r"set_point: must be PACKAGE/TYPE/FIELD \(Float32\)"),
        ("std_msgs/Float32/dat", "std_msgs/Float32 has no float field dat"),
        ("no_such/Type/x", r"set_point: type not found \(no_such/Type\)"),
    ],
)
def test_given_type_that_does_not_exist_is_refused(text: str, says: str) -> None:
    with pytest.raises(MessageTypeError, match=says):
        given_message("set_point", text, {})


def test_message_of_the_course_has_value_time_and_status() -> None:
    message = course_messages()["motor_output"]
    filled = message.filled(3.0, 1.25, "Motor Turning")
    assert filled == motor_output(3.0, 1.25, "Motor Turning")
    assert message.value(filled) == 3.0


def test_message_with_only_a_time_has_the_value_in_it(tmp_path: pathlib.Path) -> None:
    message = read(tmp_path, "reto", {"set_point": "float32 t\n"}).by_topic["set_point"]
    assert message.value(message.filled(1.5, 2.0)) == 1.5
