"""Markers of the world for rviz and for the oscilloscope's page."""

import math
from typing import Sequence

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

#: Thickness of walls, and height of walls and boxes, for display only [m].
_THICKNESS, _HEIGHT = 0.02, 0.3


def world_markers(
    frame: str, walls: Sequence[Sequence[float]], boxes: Sequence[Sequence[float]]
) -> MarkerArray:
    """Return the markers of a world, which replace markers drawn before.

    :param frame: name of their frame
    :param walls: as in :class:`.World`
    :param boxes: as in :class:`.World`
    """
    clear = Marker(action=Marker.DELETEALL)
    clear.header.frame_id = frame
    lines = _marker(frame, "walls", 0, Marker.LINE_LIST, ColorRGBA(0.3, 0.3, 0.3, 1.0))
    lines.scale.x = _THICKNESS
    lines.points = [Point(x, y, 0.0) for x1, y1, x2, y2 in walls for x, y in ((x1, y1), (x2, y2))]
    markers = [clear, lines] if walls else [clear]
    for number, (x, y, length, width, theta) in enumerate(boxes):
        box = _marker(frame, "boxes", number, Marker.CUBE, ColorRGBA(0.6, 0.5, 0.3, 1.0))
        box.pose.position = Point(x, y, 0.5 * _HEIGHT)
        box.pose.orientation.z, box.pose.orientation.w = math.sin(theta / 2), math.cos(theta / 2)
        box.scale.x, box.scale.y, box.scale.z = length, width, _HEIGHT
        markers.append(box)
    return MarkerArray(markers)


def _marker(frame: str, kind: str, number: int, shape: int, colour: ColorRGBA) -> Marker:
    marker = Marker(ns=kind, id=number, type=shape, action=Marker.ADD, color=colour)
    marker.header.frame_id = frame
    marker.pose.orientation.w = 1.0
    return marker
