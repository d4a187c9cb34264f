"""Opens recordings of ROS 1 and ROS 2, and tells which a path is."""

import os
from typing import Dict

from topic_scope.bag.file import BagFile
from topic_scope.bag.recording import Recording
from topic_scope.bag.ros2_recording import Ros2Recording
from topic_scope.messages.layouts import Layouts

#: What files of MCAP and of SQLite begin with.
_ROS2 = (b"\x89MCAP", b"SQLite format 3\0")
#: What a folder of ROS 2 has.
_FOLDER = ("metadata.yaml", ".mcap", ".db3")


def open_bag(path: str) -> Recording:
    """Open a recording.

    :param path: a bag of ROS 1; a ``.mcap`` or ``.db3`` file, or a folder of ROS 2
    :raises BagError: if it cannot be read, or holds nothing
    """
    return Ros2Recording(path) if _is_of_ros2(path) else BagFile(path)


def learn_types(bag: Recording, layouts: Layouts) -> Dict[str, str]:
    """Return the types of a recording's topics, and have its definitions count.

    What the recording says of a type counts, whatever is installed under its name.

    :param bag: the recording
    :param layouts: gets the definitions, or why one is missing
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
    except OSError:  # which opening it explains
        return False
