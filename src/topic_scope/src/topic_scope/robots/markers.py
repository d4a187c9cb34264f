# Pure: knows no ROS.
"""Markers for pages, from visualization_msgs/Marker and MarkerArray, seen from above."""

import math
from typing import Any, Dict, List, Optional, Tuple

from topic_scope.robots.frames import transform_of

#: Most markers of a topic, and most points of a marker.
_MARKERS, _POINTS = 2000, 20000
_DELETE, _DELETE_ALL = 2, 3
#: Types of visualization_msgs/Marker, and their names on a page.
_KINDS = {
    0: "arrow",
    1: "box",
    2: "disc",
    3: "disc",
    4: "strip",
    5: "lines",
    6: "boxes",
    7: "discs",
    8: "dots",
    9: "text",
}

Item = Dict[str, Any]


class Markers:
    """Current markers of one topic."""

    def __init__(self) -> None:
        #: Each with its expiry time [s].
        self._items: Dict[Tuple[str, int], Tuple[Item, float]] = {}

    def add_message(self, message: Dict[str, Any], now: float) -> None:
        """Add a message.

        :param message: a MarkerArray, or a Marker
        :param now: time of receipt [s]
        """
        for marker in message.get("markers", [message]):
            key = (marker["ns"], marker["id"])
            if marker["action"] == _DELETE_ALL:
                self._items.clear()
            elif marker["action"] == _DELETE:
                self._items.pop(key, None)
            else:
                item = _item(marker)
                if item is not None and (key in self._items or len(self._items) < _MARKERS):
                    lasts = marker["lifetime"] or math.inf
                    self._items[key] = (item, now + lasts)

    def items(self, now: float) -> List[Item]:
        """Return the current markers, each with its frame and its transform in it.

        :param now: the time [s]; expired markers are dropped
        """
        self._items = {key: one for key, one in self._items.items() if now < one[1]}
        return [item for item, _ in self._items.values()]


def _item(marker: Dict[str, Any]) -> Optional[Item]:
    kind = _KINDS.get(marker["type"])
    pose = marker["pose"]
    transform = transform_of(pose["position"], pose["orientation"])
    if kind is None or transform is None:
        return None
    points = marker["points"][:_POINTS]
    colour = [max(0.0, min(float(marker["color"][part]), 1.0)) for part in "rgba"]  # NaN: 0
    return {
        "kind": kind,
        "frame": marker["header"]["frame_id"],
        "transform": transform,
        "size": [finite(marker["scale"]["x"]), finite(marker["scale"]["y"])],
        "points": [finite(point[axis]) for point in points for axis in "xy"],
        "text": marker["text"][:200],
        "colour": colour,
    }


def finite(value: float) -> float:
    """Return a length rounded to 0.1 mm; 0 if it is not finite."""
    return round(value, 4) if abs(value) < 1e7 else 0.0
