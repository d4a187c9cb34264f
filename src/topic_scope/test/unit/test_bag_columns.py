"""Columns of a bag by name."""

from typing import List

import pytest
from bags import first_messages
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64MultiArray, Header, String

from basic_comms.msg import signal_msg
from topic_scope.bag.columns import all_columns, choose, choose_lines
from topic_scope.messages.fields import FieldError

MESSAGES = first_messages(
    {
        "/signal": signal_msg(),
        "/robot/arm": Float64MultiArray(data=[1.0, 2.0, 3.0]),
        "/robot/header": Header(),
        "/words": String(),
        "/switch": Bool(),
    }
)


def names(*expressions: str) -> List[str]:
    """Return the names of the chosen columns."""
    return [column.name for column in choose(list(expressions), MESSAGES)]


def test_columns_come_in_the_order_asked_for_and_once() -> None:
    assert names("/signal/signal_y", "/robot/header/seq", "signal/time_x", "/signal/signal_y") == [
        "/signal/signal_y",
        "/robot/header/seq",
        "/signal/time_x",
    ]


def test_several_fields_of_one_topic() -> None:
    assert names("/signal/time_x:signal_y") == ["/signal/time_x", "/signal/signal_y"]


def test_topic_alone_denotes_all_its_numbers() -> None:
    assert names("/signal") == [
        "/signal/amplitude",
        "/signal/frequency",
        "/signal/time_x",
        "/signal/signal_y",
    ]
    assert names("/switch", "/robot/header") == [
        "/switch/data",
        "/robot/header/seq",
        "/robot/header/stamp",
    ]


def test_array_is_as_long_as_in_the_message_but_any_element_may_be_asked_for() -> None:
    assert names("/robot/arm/data") == [f"/robot/arm/data[{index}]" for index in range(3)]
    assert names("/robot/arm/data[7]") == ["/robot/arm/data[7]"]


def test_elements_have_their_names_unless_an_index_was_asked_for() -> None:
    joints = JointState(name=["arm", "leg", "leg"], position=[1.0, 2.0, 3.0])
    columns = choose(["/j/position", "/j/position[0]"], first_messages({"/j": joints}))
    named = ["/j/position[arm]", "/j/position[1]", "/j/position[2]", "/j/position[0]"]
    assert [column.name for column in columns] == named


@pytest.mark.parametrize(
    "name, text",
    [
        (
            "/signal/signal_z",
            "there is no signal_z in basic_comms/signal_msg; similar names: /signal/signal_y",
        ),
        ("/sginal/signal_y", "no such topic; similar names: /signal/signal_y"),
        ("/time_x", "no such topic; similar names: /signal/time_x"),
        ("/signal/signal_y@nothing", "there is no time nothing in basic_comms/signal_msg; similar"),
        (
            "/robot/arm/dat",
            "there is no dat in std_msgs/Float64MultiArray; similar names: /robot/arm/d",
        ),
        (
            "/robot/arm/xyz",
            "there is no xyz in std_msgs/Float64MultiArray; similar names: /robot/arm/",
        ),
        (
            "/words",
            "there is no number in std_msgs/String; "
            "topics with numbers: /robot/arm, /robot/header, /signal, …",
        ),
        ("/qqq/zzz", "no such topic; topics with numbers: /robot/arm, /robot/header, /s"),
    ],
)
def test_unknown_field_is_rejected_with_similar_names(name: str, text: str) -> None:
    with pytest.raises(FieldError) as caught:
        names("/signal/signal_y", name)
    assert str(caught.value).startswith(f"{name}: {text}")


def test_bag_without_any_number() -> None:
    with pytest.raises(FieldError, match="the bag has no numbers"):
        choose(["/words/date"], first_messages({"/words": String()}))


def test_names_of_the_given_topic_are_suggested_first() -> None:
    arms = first_messages({"/robot/arm": Float64MultiArray(data=[1.0]), "/robot/arms": Bool()})
    with pytest.raises(FieldError, match=r"similar names: /robot/arm/data\[0\], /robot/arms/data"):
        choose(["/robot/arm/dat"], arms)


def test_topics_with_numbers_are_all_named_if_they_are_few() -> None:
    few = first_messages({topic: Bool() for topic in ("/a", "/b", "/c")})
    with pytest.raises(FieldError, match="topics with numbers: /a, /b, /c$"):
        choose(["/qqq/zzz"], few)


def test_all_columns_can_be_chosen_by_their_names() -> None:
    everything = all_columns(MESSAGES)
    arm = [column.name for column in everything if column.topic == "/robot/arm"]
    assert arm == ["/robot/arm/layout/data_offset"] + names("/robot/arm/data")
    assert choose([column.name for column in everything], MESSAGES) == everything


def test_a_difference_is_a_line_of_two_numbers() -> None:
    words = ["/robot/arm/data[0]-/signal/signal_y.derivative", "/switch", "/switch/data"]
    lines = choose_lines(words, MESSAGES)
    assert [[column.name for column in line.columns] for line in lines] == [
        ["/robot/arm/data[0]", "/signal/signal_y.derivative"],
        ["/switch/data"],
    ]


@pytest.mark.parametrize("name", ["/signal-/switch/data", "/switch/data-/signal/time_x:signal_y"])
def test_difference_of_several_fields_is_rejected(name: str) -> None:
    with pytest.raises(FieldError, match="one of these names denotes several"):
        choose_lines([name], MESSAGES)
