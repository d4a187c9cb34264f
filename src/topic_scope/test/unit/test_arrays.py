"""The arrays of messages: their lengths, and the names of their elements."""

import io
from typing import List

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from topic_scope.messages.arrays import Arrays, has_names
from topic_scope.messages.message_layout import layout_of
from topic_scope.messages.fields import FieldError, to_path, to_text

LAYOUT = layout_of(JointState)


def with_joints(*names: str) -> bytes:
    buffer = io.BytesIO()
    JointState(name=list(names), position=[0.0] * len(names)).serialize(buffer)
    return buffer.getvalue()


def heard(*names: str) -> Arrays:
    """Return the arrays after a message with these joints."""
    arrays = Arrays()
    arrays.add_message(LAYOUT, with_joints(*names))
    return arrays


def named(arrays: Arrays, count: int) -> List[str]:
    found = [arrays.named(("position", index)) for index in range(count)]
    return [to_text(path) for paths in found for path in paths]


def test_which_messages_have_names() -> None:
    assert has_names(LAYOUT)
    assert not has_names(layout_of(Float64MultiArray))


def test_indices_become_names_where_these_are_clear() -> None:
    expected = ["position[arm]", "position[1]", "position[2]", "position[3]", "position[4]"]
    assert named(heard("arm", "twin", "twin", "left wheel"), 5) == expected
    assert named(Arrays(), 1) == ["position[0]"]


def test_element_keeps_its_name_after_another_publisher() -> None:
    arrays = Arrays()
    assert arrays.remembered(("position", 0)) == [("position", 0)]
    expected = []
    for names in (("arm", "leg"), ("left", "right"), ("arm", "leg")):
        arrays.add_message(LAYOUT, with_joints(*names))
        expected += [name for name in names[:1] if name not in expected]
        found = [to_text(path) for path in arrays.remembered(("position", 0))]
        assert found == [f"position[{name}]" for name in expected]


def test_old_messages_expire() -> None:
    arrays = heard("arm")
    arrays.add_message(LAYOUT, with_joints("leg"), 20.0)
    arrays.check(LAYOUT, to_path("position[arm]"))
    assert named(arrays, 1) == ["position[arm]", "position[leg]"]
    arrays.add_message(LAYOUT, with_joints("leg"), 40.0)
    assert named(arrays, 1) == ["position[leg]"]
    with pytest.raises(FieldError, match="no element of position is named arm now, but leg"):
        arrays.check(LAYOUT, to_path("position[arm]"))
    for number in range(1000):
        arrays.add_message(LAYOUT, with_joints(f"n{number}"), 40.0)
    assert len(named(arrays, 1)) < 20


def test_array_keeps_its_largest_length() -> None:
    arrays = heard("a", "b", "c")
    assert arrays(("position",)) == 3
    arrays.add_message(LAYOUT, b"", 100.0)
    assert arrays(("position",)) == 3
    assert arrays(("nothing",)) == 1


def test_length_is_the_largest_of_all_publishers() -> None:
    arrays = heard("arm")
    arrays.add_message(LAYOUT, with_joints("left", "right"))
    arrays.add_message(LAYOUT, with_joints("head"))
    assert arrays(("position",)) == 2


def test_missing_element_is_reported() -> None:
    arrays = heard("arm", "leg")
    arrays.check(LAYOUT, to_path("position[leg]"))
    arrays.check(LAYOUT, to_path("position[1]"))
    for text, sentence in (
        ("position[tail]", "no element of position is named tail now, but arm, leg"),
        ("position[2]", "position has 2 elements now"),
        ("velocity[0]", "velocity has 0 elements now"),
    ):
        with pytest.raises(FieldError, match=sentence):
            arrays.check(LAYOUT, to_path(text))


def test_the_number_of_arrays_whose_lengths_are_remembered_is_limited(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("topic_scope.messages.arrays._ARRAYS", 1)
    known = heard("a", "b", "c")
    assert [known(to_path(name)) for name in ("position", "name")] == [3, 3]
    known.add_message(LAYOUT, b"", 100.0)
    assert [known(to_path(name)) for name in ("position", "name")] == [3, 0]
