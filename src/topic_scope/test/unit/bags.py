"""Bags and serialized messages for tests."""

import io
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Tuple

import genpy
import numpy
import rosbag

from topic_scope.bag.columns import Column
from topic_scope.bag.message_slices import FirstMessage, Slice
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.messages.message_layout import layout_of
from topic_scope.timing.nanoseconds import to_ns

#: Start of all bags, since the epoch [ns]: a time that a float cannot represent exactly.
BEGIN = 1700000000123456789

#: A message of a test: its time since the start of the bag, ns, its topic and itself.
BagMessage = Tuple[int, str, Any]


def write_bag(path: Path, messages: Iterable[Tuple[str, Any, int]]) -> str:
    """Record messages.

    :param path: the file
    :param messages: topic, message and time since the start, ns
    :returns: the path as text
    """
    with rosbag.Bag(str(path), "w") as bag:
        for topic, message, time in messages:
            bag.write(topic, message, genpy.Time(0, BEGIN + time))
    return str(path)


def nanoseconds(times: Iterable[float]) -> List[int]:
    """Return times in whole nanoseconds."""
    return [to_ns(time) for time in times]


def serialized(message: Any) -> bytes:
    """Return a serialized message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def first_messages(messages: Mapping[str, Any]) -> Dict[str, FirstMessage]:
    """Return messages in the form of :func:`.first_messages`."""
    return {
        topic: FirstMessage(layout_of(type(message)), serialized(message))
        for topic, message in messages.items()
    }


def reading(
    columns: Iterable[Column], sent: Iterable[BagMessage], begin: int = 0
) -> List[ColumnReader]:
    """Return the readers of columns of a bag that starts at a time [ns]."""
    first = first_messages({topic: message for _, topic, message in reversed(list(sent))})
    return [ColumnReader(column, first[column.topic], begin) for column in columns]


def slices(sent: Iterable[BagMessage]) -> List[List[Slice]]:
    """Return messages as the slices of a bag with a single chunk."""
    of_topic: Dict[str, List[BagMessage]] = {}
    for one in sent:
        of_topic.setdefault(one[1], []).append(one)
    return [
        [
            Slice(
                topic,
                numpy.array([time for time, _, _ in found], numpy.int64),
                [serialized(message) for _, _, message in found],
            )
            for topic, found in of_topic.items()
        ]
    ]
