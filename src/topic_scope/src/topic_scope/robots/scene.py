# Pure: knows no ROS.
"""Scene of robots and obstacles from messages, in their common root frame."""

import math
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy

from topic_scope.messages.message_layout import Array, MessageLayout, Scalar, Text
from topic_scope.robots.frames import FramePose, Frames, Transform, bare, transform_of
from topic_scope.robots.markers import Markers, finite

#: Types that are shown from all topics of the graph.
ODOMETRY, SCAN, PATH = "nav_msgs/Odometry", "sensor_msgs/LaserScan", "nav_msgs/Path"
GOAL = "geometry_msgs/PoseStamped"
MARKERS = ("visualization_msgs/MarkerArray", "visualization_msgs/Marker")
TRANSFORMS = ("tf2_msgs/TFMessage", "tf/tfMessage")
#: Types whose messages are all processed; of others, only the latest.
CUMULATIVE = (*MARKERS, *TRANSFORMS)
TYPES = (ODOMETRY, SCAN, PATH, GOAL, *MARKERS, *TRANSFORMS)

#: Time without messages after which a robot is silent [s].
SILENT_S = 1.0
#: Most rays of a scan, and most points of a path, that are sent to a page.
_RAYS, _POINTS = 2000, 5000

Message = Dict[str, Any]


class _Latest(NamedTuple):
    """Latest message of a topic.

    :param message: the message
    :param when: s
    """

    message: Message
    when: float


def is_status(layout: Optional[MessageLayout]) -> bool:
    """Return whether messages have the fields of robot_custom_interfaces/RobotStatus."""
    fields = dict(layout.fields) if layout is not None else {}
    name, mode, readings = (fields.get(key) for key in ("robot_name", "mode", "sensor_readings"))
    return (
        isinstance(name, Text)
        and isinstance(mode, Scalar)
        and isinstance(readings, Array)
        and isinstance(readings.element, Scalar)
    )


class Scene:
    """Latest state of all robots and obstacles; used in the web thread only, without ROS."""

    def __init__(self) -> None:
        self._frames = Frames()
        self._odometry: Dict[str, _Latest] = {}
        self._scans: Dict[str, _Latest] = {}
        self._paths: Dict[str, Message] = {}
        self._goals: Dict[str, Message] = {}
        self._markers: Dict[str, Markers] = {}
        self._statuses: Dict[str, _Latest] = {}

    def keep(self, topics: Mapping[str, str]) -> None:
        """Drop all other topics.

        :param topics: the existing topics and their types
        """
        remembered: Tuple[Dict[str, Any], ...] = (
            *(self._odometry, self._scans, self._paths),
            *(self._goals, self._markers, self._statuses),
        )
        for messages in remembered:
            for topic in set(messages) - set(topics):
                del messages[topic]
        self._frames.keep(topics)

    def add_message(self, topic: str, datatype: str, message: Message, now: float) -> None:
        """Add a message.

        :param topic: its topic
        :param datatype: its type; a type that is not in TYPES is a robot status
        :param message: as :class:`.MessageReader` reads it
        :param now: time of receipt [s]
        """
        if datatype == ODOMETRY:
            self._add_odometry(topic, message, now)
        elif datatype == SCAN:
            seen = {"frame": message["header"]["frame_id"], "rays": _rays(message)}
            self._scans[topic] = _Latest(seen, now)
        elif datatype == PATH:
            self._paths[topic] = _points(message)
        elif datatype == GOAL:
            self._add_goal(topic, message)
        elif datatype in MARKERS:
            self._markers.setdefault(topic, Markers()).add_message(message, now)
        elif datatype in TRANSFORMS:
            self._add_transforms(topic, message)
        else:
            self._statuses[topic] = _Latest(_status(message), now)

    def _add_odometry(self, topic: str, message: Message, now: float) -> None:
        pose, twist = message["pose"]["pose"], message["twist"]["twist"]
        transform = transform_of(pose["position"], pose["orientation"])
        if transform is None:
            return
        frame = message["header"]["frame_id"]
        speeds = {"speed": finite(twist["linear"]["x"]), "turn": finite(twist["angular"]["z"])}
        body = message["child_frame_id"]
        odometry = {"frame": frame, "body": bare(body), "transform": transform, **speeds}
        self._odometry[topic] = _Latest(odometry, now)
        self._frames.set_odometry(topic, frame, body, transform)

    def _add_goal(self, topic: str, message: Message) -> None:
        transform = transform_of(message["pose"]["position"], message["pose"]["orientation"])
        if transform is not None:
            frame = message["header"]["frame_id"]
            self._goals[topic] = {"frame": frame, "transform": transform}

    def _add_transforms(self, topic: str, message: Message) -> None:
        for one in message["transforms"]:
            there = one["transform"]
            transform = transform_of(there["translation"], there["rotation"])
            if transform is not None:
                parent, child = one["header"]["frame_id"], one["child_frame_id"]
                self._frames.set_transform(topic, parent, child, transform)

    # --- For pages ---------------------------------------------------------------------------

    def moving(self, now: float) -> Message:
        """Return the poses of the robots, and their laser scans.

        :param now: the time [s]
        """
        robots = [
            self._robot(topic, *latest, now) for topic, latest in sorted(self._odometry.items())
        ]
        scans = [
            self._scan(topic, latest.message)
            for topic, latest in sorted(self._scans.items())
            if now - latest.when < SILENT_S
        ]
        return {"type": "robots", "robots": robots, "scans": [one for one in scans if one]}

    def _robot(self, topic: str, odometry: Message, when: float, now: float) -> Message:
        place = self._placed(odometry["frame"], odometry["transform"])
        return {
            "topic": topic,
            "frame": place.root,
            "body": odometry["body"],
            "x": finite(place.transform.position[0]),
            "y": finite(place.transform.position[1]),
            "heading": finite(place.transform.heading),
            "speed": odometry["speed"],
            "turn": odometry["turn"],
            "silent": now - when > SILENT_S,
        }

    def _scan(self, topic: str, scan: Message) -> Optional[Message]:
        place = self._frames.pose_of(scan["frame"]).transform
        if not self._frames.knows(scan["frame"]):  # assume the pose of the robot in its namespace
            space = topic.rpartition("/")[0]
            near = [name for name in self._odometry if name.rpartition("/")[0] == space]
            if not near:
                return None
            odometry = self._odometry[near[0]].message
            place = self._placed(odometry["frame"], odometry["transform"]).transform
        return {"topic": topic, "at": _numbers(place.flat()), **scan["rays"]}

    def _placed(self, frame: str, transform: Transform) -> FramePose:
        place = self._frames.pose_of(frame)
        return FramePose(place.root, place.transform.then(transform))

    def standing(self, now: float) -> Message:
        """Return the parts that change rarely: markers, paths, goals.

        :param now: the time [s]
        """
        markers = [self._marker(item) for one in self._markers.values() for item in one.items(now)]
        return {
            "type": "scenery",
            "markers": markers,
            "paths": [self._path(topic, path) for topic, path in sorted(self._paths.items())],
            "goals": [self._goal(topic, goal) for topic, goal in sorted(self._goals.items())],
        }

    def _marker(self, item: Message) -> Message:
        shown = {name: value for name, value in item.items() if name not in ("frame", "transform")}
        place = self._placed(item["frame"], item["transform"]).transform
        return {**shown, "at": _numbers(place.flat())}

    def _path(self, topic: str, path: Message) -> Message:
        at = self._frames.pose_of(path["frame"]).transform.flat()
        return {"topic": topic, "at": _numbers(at), "points": path["points"]}

    def _goal(self, topic: str, goal: Message) -> Message:
        there = self._placed(goal["frame"], goal["transform"]).transform
        x, y, _ = there.position
        return {"topic": topic, "x": finite(x), "y": finite(y), "heading": finite(there.heading)}

    def fleet(self, now: float) -> Message:
        """Return the status of the robots.

        :param now: the time [s]
        """
        robots = []
        for topic, (status, when) in self._statuses.items():
            age = round(now - when, 1) if now - when > SILENT_S else None
            robots.append({"topic": topic, **status, "age": age})
        return {"type": "fleet", "robots": sorted(robots, key=lambda one: str(one["name"]))}


def _rays(scan: Message) -> Message:
    every = max(1, -(-len(scan["ranges"]) // _RAYS))
    ranges = scan["ranges"][::every].astype(float)
    with numpy.errstate(invalid="ignore"):
        fine = (ranges >= scan["range_min"]) & (ranges <= scan["range_max"]) & (ranges < 1e6)
    first, step = float(scan["angle_min"]), float(scan["angle_increment"]) * every
    # In mm, 0 without an echo: short in JSON.
    numbers = numpy.where(fine & math.isfinite(first + step), numpy.rint(ranges * 1e3), 0.0)
    bounded = {"first": _or_zero(first), "step": _or_zero(step)}
    return {**bounded, "ranges": numbers.astype(int).tolist()}


def _points(path: Message) -> Message:
    places = [pose["pose"]["position"] for pose in path["poses"][-_POINTS:]]
    points = [finite(place[axis]) for place in places for axis in "xy"]
    return {"frame": path["header"]["frame_id"], "points": points}


def _status(message: Message) -> Message:
    readings = [float(f"{value:.4g}") for value in message["sensor_readings"][:10]]
    return {
        "name": message["robot_name"][:100],
        "mode": int(message["mode"]),
        "readings": [value if math.isfinite(value) else None for value in readings],
    }


def _or_zero(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _numbers(values: List[float]) -> List[float]:
    return [finite(value) for value in values]
