# Pure: knows no ROS.
"""Tree of coordinate frames from ``/tf`` and odometry, seen from above."""

import math
from typing import Container, Dict, List, Mapping, NamedTuple, Optional, Tuple

Vector = Tuple[float, float, float]
#: x, y, z, w.
Quaternion = Tuple[float, float, float, float]

#: Longest chain of frames to follow; a cycle would have no end.
_DEPTH = 100
#: Most frames that are stored.
_FRAMES = 5000


class Transform(NamedTuple):
    """Pose in a frame.

    :param position: m
    :param rotation: as a unit quaternion
    """

    position: Vector
    rotation: Quaternion

    def then(self, inner: "Transform") -> "Transform":
        """Return the composition with an inner transform.

        :param inner: a pose in the frame of this transform
        """
        turned = _turned(self.rotation, inner.position)
        x, y, z = (a + b for a, b in zip(self.position, turned))
        return Transform((x, y, z), _product(self.rotation, inner.rotation))

    @property
    def heading(self) -> float:
        """Angle of its x axis, seen from above [rad]."""
        x, y, z, w = self.rotation
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    def flat(self) -> List[float]:
        """Return the projection from above, as a transformation of a canvas."""
        along, across = (
            _turned(self.rotation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        )
        return [*along[:2], *across[:2], *self.position[:2]]


IDENTITY = Transform((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def transform_of(
    position: Mapping[str, float], rotation: Mapping[str, float]
) -> Optional[Transform]:
    """Return the transform in a message.

    :param position: its x, y, z
    :param rotation: its x, y, z, w; all zero (unset) is the identity
    :returns: the transform; None if a value is not finite
    """
    place = tuple(float(position[name]) for name in "xyz")
    turn = tuple(float(rotation[name]) for name in "xyzw")
    length = math.sqrt(sum(part * part for part in turn))
    if not all(map(math.isfinite, place)) or not math.isfinite(length):
        return None
    unit = tuple(part / length for part in turn) if length > 1e-9 else IDENTITY.rotation
    return Transform(place, unit)  # type: ignore[arg-type]


class FramePose(NamedTuple):
    """Pose of a frame in the root of its tree.

    :param root: root frame of the tree
    :param transform: pose in the root
    """

    root: str
    transform: Transform


class Frames:
    """Latest transforms of all frames."""

    def __init__(self) -> None:
        #: For each frame by topic, the latest last: its parent frame and transform.
        self._parents: Dict[str, Dict[str, Tuple[str, Transform]]] = {}
        #: For each frame: the topic of its odometry, its parent frame and transform.
        self._guesses: Dict[str, Tuple[str, str, Transform]] = {}

    def keep(self, topics: Container[str]) -> None:
        """Drop the transforms of all other topics."""
        parents = {
            child: {topic: place for topic, place in sources.items() if topic in topics}
            for child, sources in self._parents.items()
        }
        self._parents = {child: sources for child, sources in parents.items() if sources}
        self._guesses = {
            child: guess for child, guess in self._guesses.items() if guess[0] in topics
        }

    def set_transform(self, source: str, parent: str, child: str, transform: Transform) -> None:
        """Set a transform of ``/tf``.

        :param source: its topic
        """
        child = bare(child)
        if len(self._parents) < _FRAMES or child in self._parents:
            sources = self._parents.setdefault(child, {})
            sources.pop(source, None)
            sources[source] = (bare(parent), transform)

    def set_odometry(self, source: str, parent: str, child: str, transform: Transform) -> None:
        """Set the transform of an odometry; a transform of ``/tf`` takes precedence.

        :param source: its topic; of two odometries of one robot, the first by name is used
        """
        child = bare(child)
        known = self._guesses.get(child)
        if child and (known is None or source <= known[0]):
            self._guesses[child] = (source, bare(parent), transform)

    def knows(self, frame: str) -> bool:
        """Return whether a frame has a known pose."""
        return bare(frame) in self._parents or bare(frame) in self._guesses

    def pose_of(self, frame: str) -> FramePose:
        """Return the pose of a frame; an unknown frame is its own root."""
        frame, transform = bare(frame), IDENTITY
        for _ in range(_DEPTH):
            if frame in self._parents:
                frame, step = next(reversed(self._parents[frame].values()))
            elif frame in self._guesses:
                _, frame, step = self._guesses[frame]
            else:
                break
            transform = step.then(transform)
        return FramePose(frame, transform)


def bare(frame: str) -> str:
    """Return a frame's name without the leading slash of tf1."""
    return frame.lstrip("/")


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _turned(rotation: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = rotation
    turned = _product(_product(rotation, (*vector, 0.0)), (-x, -y, -z, w))
    return turned[:3]
