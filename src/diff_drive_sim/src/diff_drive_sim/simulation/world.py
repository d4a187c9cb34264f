"""World of a robot: a plane with walls and boxes.

Pure Python, so that a robot without a laser does not need numpy.
"""

import math
from typing import List, Sequence, Tuple

from diff_drive_sim.simulation.kinematics import Pose

#: From x, y to x, y [m].
Segment = Tuple[float, float, float, float]

#: Number of bisections, for a contact exact to a billionth of the path.
_HALVINGS = 30


class World:
    """Walls, which are lines, and boxes, which are four walls each.

    :param walls: x and y of the start, x and y of the end [m]
    :param boxes: x and y of the centre, length along the box's own x and width, m, heading [rad]
    """

    def __init__(
        self, walls: Sequence[Sequence[float]] = (), boxes: Sequence[Sequence[float]] = ()
    ) -> None:
        self.segments: List[Segment] = [(x1, y1, x2, y2) for x1, y1, x2, y2 in walls]
        for box in boxes:
            corners = box_corners(*box)
            for (x1, y1), (x2, y2) in zip(corners, corners[1:] + corners[:1]):
                self.segments.append((x1, y1, x2, y2))

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the nearest wall [m]; infinite without a wall.

        :param x: [m]
        :param y: [m]
        """
        return min((_distance(x, y, segment) for segment in self.segments), default=math.inf)

    def free_part(self, pose: Pose, distance: float, turn: float, radius: float) -> float:
        """Return how much of an arc a round robot can drive before it touches a wall, 0 to 1.

        Each step advances by the current distance to the nearest wall, so a long arc takes few
        steps and skips no wall. A robot that already touches a wall, or is inside one, may drive
        away from it.

        :param pose: start of the arc
        :param distance: length of the arc [m]; below 0 backwards
        :param turn: change of the heading on it [rad]
        :param radius: of the robot [m]
        """
        length = abs(distance)
        if not self.segments or length == 0.0:
            return 1.0

        def clearance(part: float) -> float:
            x, y, _ = pose.moved(part * distance, part * turn)
            return self.distance(x, y) - radius

        # A step below the radius cannot skip a wall.
        least = max(0.1 * radius, 1e-3)
        part, room = 0.0, clearance(0.0)
        while part < 1.0:
            following = min(part + max(room, least) / length, 1.0)
            left = clearance(following)
            if left < 0.0 and left < room:
                for _ in range(_HALVINGS):
                    middle = 0.5 * (part + following)
                    if clearance(middle) >= min(room, 0.0):
                        part = middle
                    else:
                        following = middle
                return part
            part, room = following, left
        return 1.0


def box_corners(
    x: float, y: float, length: float, width: float, theta: float
) -> List[Tuple[float, float]]:
    """Return the corners of a box, counter-clockwise [m].

    :param x: of the centre [m]
    :param y: of the centre [m]
    :param length: along the box's own x [m]
    :param width: [m]
    :param theta: its heading [rad]
    """
    cosine, sine = math.cos(theta), math.sin(theta)
    signs = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
    return [
        (x + a * length * cosine - b * width * sine, y + a * length * sine + b * width * cosine)
        for a, b in signs
    ]


def _distance(x: float, y: float, segment: Segment) -> float:
    """Return the distance of a point from a line between two points [m]."""
    x1, y1, x2, y2 = segment
    along_x, along_y = x2 - x1, y2 - y1
    square = along_x * along_x + along_y * along_y
    part = ((x - x1) * along_x + (y - y1) * along_y) / square if square > 0.0 else 0.0
    part = min(1.0, max(0.0, part))
    return math.hypot(x - x1 - part * along_x, y - y1 - part * along_y)
