"""Static transforms that a ROS 1 node latches in several messages."""

import struct
from typing import List, Tuple

from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.topics.static_transforms import StaticTransforms

Transform = Tuple[str, str, float]


def message(transforms: List[Transform]) -> bytes:
    """Return a TFMessage in ROS 1's format."""
    parts = [struct.pack("<I", len(transforms))]
    for parent, child, x in transforms:
        parts.append(struct.pack("<III", 5, 6, 7))
        for name in (parent.encode(), child.encode()):
            parts.append(struct.pack("<I", len(name)) + name)
        parts.append(struct.pack("<7d", x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    return b"".join(parts)


def test_transforms_of_later_messages_are_added() -> None:
    joined = StaticTransforms()
    left, right = ("base", "left", 1.0), ("base", "right", 2.0)
    assert joined.join(message([left])) == message([left])
    assert joined.join(message([right])) == message([left, right])
    assert joined.join(message([])) == message([left, right])


def test_later_transform_of_a_frame_replaces_the_former() -> None:
    joined = StaticTransforms()
    joined.join(message([("base", "left", 1.0), ("base", "right", 2.0)]))
    moved = ("other", "left", 3.0)
    assert joined.join(message([moved])) == message([moved, ("base", "right", 2.0)])


_NAMES = st.text(max_size=6)


@given(st.lists(st.lists(st.tuples(_NAMES, _NAMES, st.floats(allow_nan=False)), max_size=4)))
def test_every_frame_has_its_latest_transform(messages: List[List[Transform]]) -> None:
    joined, last, latest = StaticTransforms(), message([]), {}
    for transforms in messages:
        last = joined.join(message(transforms))
        latest.update({child: (parent, child, x) for parent, child, x in transforms})
    assert last == message(list(latest.values()))
