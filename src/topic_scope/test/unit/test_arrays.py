"""The arrays of messages: their lengths, and the names of their elements."""

import io
from typing import List

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from topic_scope.arrays import Arrays, has_names
from topic_scope.definitions import layout_of
from topic_scope.fields import FieldError, to_path, to_text

LAYOUT = layout_of(JointState)


def heard(*names: str) -> Arrays:
    """Return what is known after a message with these joints."""
    buffer = io.BytesIO()
    JointState(name=list(names), position=[0.0] * len(names)).serialize(buffer)
    arrays = Arrays()
    arrays.look(LAYOUT, buffer.getvalue())
    return arrays


def named(arrays: Arrays, count: int) -> List[str]:
    return [to_text(arrays.named(("position", index))) for index in range(count)]


def test_which_messages_have_names() -> None:
    assert has_names(LAYOUT)
    assert not has_names(layout_of(Float64MultiArray))


def test_indices_become_names_where_these_are_clear() -> None:
    expected = ["position[arm]", "position[1]", "position[2]", "position[3]", "position[4]"]
    assert named(heard("arm", "twin", "twin", "left wheel"), 5) == expected
    assert named(Arrays(), 1) == ["position[0]"]


def test_what_has_got_a_name_keeps_it_whoever_publishes_next() -> None:
    arrays = Arrays()
    assert arrays.first_named(("position", 0)) == ("position", 0)
    for names in (("arm", "leg"), ("left", "right")):
        buffer = io.BytesIO()
        JointState(name=list(names), position=[0.0] * 2).serialize(buffer)
        arrays.look(LAYOUT, buffer.getvalue())
        assert to_text(arrays.first_named(("position", 0))) == "position[arm]"


def test_an_array_is_as_long_as_it_has_ever_been() -> None:
    arrays = heard("a", "b", "c")
    assert arrays(("position",)) == 3
    arrays.look(LAYOUT, b"")
    assert arrays(("position",)) == 3
    assert arrays(("nothing",)) == 1


def test_what_is_not_in_the_latest_message_is_said() -> None:
    arrays = heard("arm", "leg")
    arrays.check(LAYOUT, to_path("position[leg]"))
    arrays.check(LAYOUT, to_path("position[1]"))
    for text, sentence in (
        ("position[tail]", "none of position is called tail now, but arm, leg"),
        ("position[2]", "position has 2 elements now"),
        ("velocity[0]", "velocity has 0 elements now"),
    ):
        with pytest.raises(FieldError, match=sentence):
            arrays.check(LAYOUT, to_path(text))


def test_the_number_of_arrays_whose_lengths_are_remembered_is_limited(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("topic_scope.arrays._ARRAYS", 1)
    known = heard("a", "b", "c")
    assert [known(to_path(name)) for name in ("position", "name")] == [3, 3]
    known.look(LAYOUT, b"")
    assert [known(to_path(name)) for name in ("position", "name")] == [3, 0]
