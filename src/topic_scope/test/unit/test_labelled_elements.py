"""Elements of arrays that are found by the value of a field."""

from pathlib import Path
from typing import Any, List

import numpy
import pytest
from bags import serialized, write_bag
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st
from tf2_msgs.msg import TFMessage

from topic_scope.bag.columns import choose
from topic_scope.bag.message_slices import first_messages
from topic_scope.bag.opening import open_bag
from topic_scope.bag.overlay import BagOverlay
from topic_scope.formulas.names import expand, terms
from topic_scope.messages.arrays import Arrays
from topic_scope.messages.decoding import Decoder
from topic_scope.messages.message_layout import layout_of, parse
from topic_scope.messages.fields import FieldError, leaf_at, parted, split, to_path, to_text

X = "transform/translation/x"
VALUES = st.text([chr(code) for code in range(32, 127) if chr(code) not in ']["'], min_size=1)


def transforms(**frames: float) -> TFMessage:
    """Return transforms by child frame, each with a translation along x."""
    made = []
    for name, way in frames.items():
        one = TransformStamped(child_frame_id=name)
        one.header.frame_id = "odom" * len(name)
        one.transform.translation.x = way
        made.append(one)
    return TFMessage(made)


def test_first_element_with_the_value_is_read_wherever_it_is() -> None:
    layout = layout_of(TFMessage)
    decoder = Decoder(layout, to_path(f"transforms[child_frame_id=base]/{X}"))
    sent = [transforms(base=1.0), transforms(arm=2.0, base=3.0), transforms(arm=4.0), TFMessage()]
    twice = TFMessage(transforms(base=5.0).transforms + transforms(base=6.0).transforms)
    values = decoder.decode([serialized(one) for one in [*sent, twice]])
    assert values[[0, 1, 4]].tolist() == [1.0, 3.0, 5.0] and numpy.isnan(values[2:4]).all()
    nested = Decoder(layout, to_path(f"transforms[header/frame_id=odomodomodom]/{X}"))
    assert nested.decode([serialized(sent[1])]).tolist() == [2.0]


def test_numbers_find_elements_of_fixed_arrays_too() -> None:
    layout = parse("a/A", "B[3] all\n" + "=" * 80 + "\nMSG: a/B\nint16 id\nfloat32 x")
    data = b"".join(
        numpy.int16(number).tobytes() + numpy.float32(number / 2).tobytes() for number in (7, -3, 5)
    )
    values = [Decoder(layout, to_path(f"all[id={n}]/x")).decode([data, data]) for n in (-3, 5, 4)]
    assert [one.tolist() for one in values[:2]] == [[-1.5, -1.5], [2.5, 2.5]]
    assert numpy.isnan(values[2]).all()
    for wrong in ("x=1", "y=1"):
        with pytest.raises(FieldError):
            leaf_at(layout, to_path(f"all[{wrong}]/x"))


@given(VALUES)
def test_any_value_can_be_written(value: str) -> None:
    name = f"/diagnostics/status[name={value}]/level"
    assert expand(name) == [name] and terms(name) == (name,)
    assert expand(f"={name} - 2") == [f"={name} - 2"] and terms(f"={name} - 2") == (name,)
    assert terms(f"{name}-/a/x") == (name, "/a/x")
    assert parted(f"{name}.difference@stamp") == (name, "difference", "stamp")
    topic, rest = split(name, ["/diagnostics", "/diagnostics/status"]) or ("", "")
    assert (topic, to_text(to_path(rest))) == ("/diagnostics", f"status[name={value}]/level")
    assert expand(f"{name[:-6]}/level:name") == [name, f"{name[:-6]}/name"]


def test_topic_with_several_publishers_has_all_of_their_frames() -> None:
    layout, arrays = layout_of(TFMessage), Arrays()
    for time, message in ((1.0, transforms(base=1.0)), (2.0, transforms(arm=2.0))):
        arrays.add_message(layout, serialized(message), time)
    paths = arrays.named(to_path(f"transforms[0]/{X}"))
    assert {to_text(path) for path in paths} == {
        f"transforms[child_frame_id={name}]/{X}" for name in ("base", "arm")
    }
    for path in paths:
        arrays.check(layout, path)
    with pytest.raises(FieldError) as caught:
        arrays.check(layout, to_path(f"transforms[child_frame_id=leg]/{X}"))
    assert str(caught.value) == ("no element of transforms has the child_frame_id leg now, but arm")


@pytest.fixture
def bag(tmp_path: Path) -> str:
    messages: List[Any] = []
    for index in range(4):
        frames = {"base": float(index)} if index % 2 else {"arm": 9.0, "base": float(index)}
        messages.append(("/tf", transforms(**frames), index * 10**9))
        status = DiagnosticStatus(name="drive: left motor", level=index)
        messages.append(("/diagnostics", DiagnosticArray(status=[status]), index * 10**9))
    return write_bag(tmp_path / "x.bag", messages)


def test_bag_has_lines_by_their_values(bag: str) -> None:
    with open_bag(bag) as opened:
        first = first_messages(opened)
        names = [
            column.name for column in choose(["/tf/transforms[1]/transform/translation"], first)
        ]
    assert names == [f"/tf/transforms[1]/transform/translation/{axis}" for axis in "xyz"]
    with open_bag(bag) as opened:
        names = [column.name for column in choose(["/diagnostics", "/tf"], first_messages(opened))]
    assert "/diagnostics/status[name=drive: left motor]/level" in names
    assert f"/tf/transforms[child_frame_id=arm]/{X}" in names
    overlay = BagOverlay(bag, "old")
    level, base, arm = overlay.read(
        [
            "=2*/diagnostics/status[name=drive: left motor]/level",
            f"/tf/transforms[child_frame_id=base]/{X}",
            f"/tf/transforms[child_frame_id=arm]/{X}",
        ]
    )
    assert list(level.values) == [0.0, 2.0, 4.0, 6.0]
    assert list(base.values) == [0.0, 1.0, 2.0, 3.0] and list(arm.values) == [9.0, 9.0]
    assert list(arm.times) == [0.0, 2.0]
