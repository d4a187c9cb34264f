"""Bags to be read in tests."""

from pathlib import Path
from typing import Any, Iterable, Tuple

import genpy
import rosbag

#: When all of them begin, since the epoch, ns: a time that a float cannot hold exactly.
BEGIN = 1700000000123456789


def write_bag(path: Path, messages: Iterable[Tuple[str, Any, int]]) -> str:
    """Record messages.

    :param path: the file
    :param messages: topic, message and time since the begin, ns
    :returns: the path as text
    """
    with rosbag.Bag(str(path), "w") as bag:
        for topic, message, time in messages:
            bag.write(topic, message, genpy.Time(0, BEGIN + time))
    return str(path)
