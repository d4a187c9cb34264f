"""Tree of frames in three dimensions, seen from above."""

import math

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.robots.frames import IDENTITY, Frames, Transform, transform_of

numbers = st.floats(-5.0, 5.0)


def turned(angle: float, x: float = 0.0, y: float = 0.0) -> Transform:
    return Transform((x, y, 0.0), (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)))


def matrix(transform: Transform) -> numpy.ndarray:
    x, y, z, w = transform.rotation
    skew = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = numpy.eye(3) + 2 * w * skew + 2 * skew @ skew
    whole = numpy.eye(4)
    whole[:3, :3], whole[:3, 3] = rotation, transform.position
    return whole


transforms = st.builds(
    lambda place, turn: transform_of(dict(zip("xyz", place)), dict(zip("xyzw", turn))),
    st.tuples(*[numbers] * 3),
    st.tuples(*[numbers] * 4),
)


@settings(max_examples=30)
@given(transforms, transforms)
def test_transforms_are_put_together_as_matrices_are(one: Transform, other: Transform) -> None:
    expected = matrix(one) @ matrix(other)
    assert numpy.allclose(matrix(one.then(other)), expected, atol=1e-9)
    flat = one.then(other).flat()
    assert numpy.allclose(flat, [*expected[:2, 0], *expected[:2, 1], *expected[:2, 3]], atol=1e-9)


@settings(max_examples=30)
@given(st.floats(-3.1, 3.1))
def test_a_heading_is_the_angle_of_the_nose(angle: float) -> None:
    assert turned(angle).heading == pytest.approx(angle, abs=1e-12)


def test_a_laser_is_found_through_its_robot_and_the_map() -> None:
    frames = Frames()
    frames.set_transform("/tf", "/map", "odom", turned(0.0, 10.0, 0.0))
    frames.set_transform("/tf", "odom", "base", turned(math.pi / 2, 1.0, 2.0))
    frames.set_transform("/tf", "base", "/laser", turned(0.0, 0.5, 0.0))
    place = frames.pose_of("laser")
    assert place.root == "map" and frames.knows("/laser") and not frames.knows("map")
    assert place.transform.position == pytest.approx((11.0, 2.5, 0.0))
    assert frames.pose_of("elsewhere") == ("elsewhere", IDENTITY)


def test_latest_of_two_topics_places_a_frame() -> None:
    frames = Frames()
    for topic, x in (("/tf", 1.0), ("/tf_static", 2.0), ("/tf", 3.0)):
        frames.set_transform(topic, "map", "base", turned(0.0, x))
    assert frames.pose_of("base").transform.position[0] == 3.0


def test_first_odometry_by_name_places_its_robot() -> None:
    frames = Frames()
    for topic, x in (("/b", 1.0), ("/a", 2.0), ("/b", 3.0), ("/a", 4.0)):
        frames.set_odometry(topic, "/odom", "/base", turned(0.0, x))
    frames.set_odometry("/c", "odom", "", turned(0.0, 5.0))  # its robot has no frame
    assert frames.pose_of("base") == ("odom", turned(0.0, 4.0))
    assert frames.knows("/base") and not frames.knows("")


def test_full_tree_still_updates_its_frames(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr("topic_scope.robots.frames._FRAMES", 1)
    frames = Frames()
    frames.set_transform("/tf", "map", "base", turned(0.0, 1.0))
    frames.set_transform("/tf", "map", "arm", turned(0.0, 1.0))
    frames.set_transform("/tf", "map", "base", turned(0.0, 2.0))
    assert frames.pose_of("base").transform.position[0] == 2.0 and not frames.knows("arm")


def test_odometry_is_used_without_transforms() -> None:
    frames = Frames()
    frames.set_odometry("/b/odom", "odom", "base", turned(0.0, 2.0))
    frames.set_odometry("/a/odom", "odom", "base", turned(0.0, 1.0))
    frames.set_odometry("/b/odom", "odom", "base", turned(0.0, 3.0))
    assert frames.pose_of("base").transform.position[0] == 1.0
    frames.set_transform("/tf", "odom", "base", turned(0.0, 7.0))
    assert frames.pose_of("base").transform.position[0] == 7.0


def test_another_topic_replaces_a_removed_one() -> None:
    frames = Frames()
    frames.set_transform("/tf_static", "map", "odom", turned(0.0, 1.0))
    frames.set_transform("/tf", "map", "odom", turned(0.0, 2.0))
    assert frames.pose_of("odom").transform.position[0] == 2.0
    frames.keep(["/tf_static"])
    assert frames.pose_of("odom").transform.position[0] == 1.0
    frames.keep([])
    assert not frames.knows("odom")


def test_a_ring_of_frames_ends() -> None:
    frames = Frames()
    frames.set_transform("/tf", "a", "b", IDENTITY)
    frames.set_transform("/tf", "b", "a", IDENTITY)
    assert frames.pose_of("a").root in ("a", "b")


def test_non_finite_transform_is_rejected() -> None:
    place, turn = dict(zip("xyz", (0.0, 0.0, math.nan))), dict(zip("xyzw", (0.0, 0.0, 0.0, 1.0)))
    assert transform_of(place, turn) is None
    assert transform_of(dict.fromkeys("xyz", 1.0), dict.fromkeys("xyzw", 0.0)) == (
        (1.0, 1.0, 1.0),
        (0.0, 0.0, 0.0, 1.0),
    )
