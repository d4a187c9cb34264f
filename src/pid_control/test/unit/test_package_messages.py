"""Tests of the messages of a package, generated without a build."""

import pathlib
from unittest import mock

import pytest
from std_msgs.msg import Float32

from pid_control.programs.package_messages import (
    MessageTypeError,
    check_legal,
    class_of,
    definitions,
    generate,
    package_name,
)


def test_definitions_are_the_message_files_of_a_package(tmp_path: pathlib.Path) -> None:
    assert definitions("") == definitions(str(tmp_path)) == {}
    (tmp_path / "msg").mkdir()
    for name in ("b.msg", "a.msg", "README", "c.srv"):
        (tmp_path / "msg" / name).write_text(f"# {name}\n")
    (tmp_path / "msg" / "d.msg").write_bytes(b"# \xff")
    found = definitions(str(tmp_path))
    assert list(found.items()) == [("a", "# a.msg\n"), ("b", "# b.msg\n"), ("d", "# \ufffd")]


@pytest.mark.parametrize(
    "text, name",
    [
        ("<package><name> anna\n</name></package>", "anna"),
        ("<package/>", ""),
        ("<broken", ""),
        (None, ""),
    ],
)
def test_package_name_is_that_of_its_file(text: str, name: str, tmp_path: pathlib.Path) -> None:
    if text is not None:
        (tmp_path / "package.xml").write_text(text)
    assert package_name(str(tmp_path)) == name


def test_check_legal_names_the_rule_and_a_bounded_part_of_the_name() -> None:
    for name in ("a", "Anna_2", "a_"):
        check_legal(name)
    for name in ("", "_a", "2a", "a-b", "a/b", "\u00e4", "a\n"):
        with pytest.raises(MessageTypeError) as error:
            check_legal(name)
        rule = "package.xml: <name> must be letters, digits and _, with a letter first"
        assert str(error.value) == f"{rule} ({name!r})"
    with pytest.raises(MessageTypeError, match=rf"\('{'-' * 80}'\)$"):
        check_legal("-" * 81)


def test_generated_classes_may_use_other_packages_and_each_other(tmp_path: pathlib.Path) -> None:
    texts = {"wave": "std_msgs/Header header\npart[] parts\n", "part": "float32 y\n"}
    found = generate("anna", texts, str(tmp_path))
    assert list(found) == ["anna/wave", "anna/part"]
    assert found["anna/wave"].__slots__ == ["header", "parts"]
    assert (tmp_path / "anna" / "__init__.py").read_text().startswith("import pkgutil\n")
    names = {path.name for path in (tmp_path / "anna" / "msg").iterdir()}
    assert names == {"__init__.py", "_wave.py", "_part.py"}


@pytest.mark.parametrize("text", ["no_such/Type x\n", "float32\n", "part x\n"])
def test_broken_definitions_have_no_classes(
    text: str, tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    assert generate("anna", {"wave": text}, str(tmp_path)) == {}
    assert capsys.readouterr().err == ""


def test_class_of_a_type_is_the_students_or_an_installed_one() -> None:
    own = mock.Mock()
    assert class_of("/x", "std_msgs/Float32", {"std_msgs/Float32": own}) is own
    assert class_of("/x", "std_msgs/Float32", {}) is Float32
    for wrong in ("std_msgs/Nothing", "no_such/Type", "Float32", "a/b/c"):
        with pytest.raises(MessageTypeError) as error:
            class_of("/x", wrong, {})
        assert str(error.value) == f"/x: type not found ({wrong}); build its package first"
