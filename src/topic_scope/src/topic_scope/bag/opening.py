"""Opening of ROS 1 and ROS 2 recordings by path."""

import os
from typing import Dict

from topic_scope.bag.recording import Recording
from topic_scope.bag.ros1_recording import Ros1Recording
from topic_scope.bag.ros2_recording import Ros2Recording
from topic_scope.messages.layout_cache import Layouts

#: First bytes of MCAP and SQLite files.
_ROS2 = (b"\x89MCAP", b"SQLite format 3\0")
#: File in the folder of a ROS 2 recording.
_FOLDER = ("metadata.yaml", ".mcap", ".db3")


def open_bag(path: str) -> Recording:
    """Open a recording.

    :param path: a ROS 1 bag; a ``.mcap`` or ``.db3`` file, or a folder of a ROS 2 recording
    :raises BagError: if it cannot be read, or has no messages
    """
    return Ros2Recording(path) if _is_of_ros2(path) else Ros1Recording(path)


def learn_types(bag: Recording, layouts: Layouts) -> Dict[str, str]:
    """Return the types of a recording's topics, and register its definitions.

    The recording's definition of a type takes precedence over an installed one.

    :param bag: the recording
    :param layouts: receives the definitions, or the reason why one is missing
    """
    types: Dict[str, str] = {}
    for topic, header in bag.connections.values():
        datatype = types.setdefault(topic, header.get("type", "*"))
        if topic in bag.faults:
            layouts.reject(header, bag.faults[topic])
        elif layouts.received(header) is None:
            bag.faults[topic] = layouts.problem(datatype) or ""
    return types


def _is_of_ros2(path: str) -> bool:
    try:
        if os.path.isdir(path):
            return any(name.endswith(_FOLDER) for name in os.listdir(path))
        with open(path, "rb") as file:
            return file.read(16).startswith(_ROS2)
    except OSError:  # opening it reports the cause
        return False
