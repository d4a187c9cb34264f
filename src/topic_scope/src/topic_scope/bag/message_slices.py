"""Reader of a bag's messages about a chunk at a time, by topic, in time order."""

from typing import Collection, Dict, Iterator, List, NamedTuple, Optional

import numpy

from topic_scope.bag.recording import BagError, ConnectionMessages, Recording
from topic_scope.messages import message_layout


class Slice(NamedTuple):
    """Messages of one topic.

    :param topic: its global name
    :param times: when they were recorded, ascending, since the start of the bag [ns]
    :param messages: serialized messages
    """

    topic: str
    times: numpy.ndarray
    messages: List[bytes]

    @classmethod
    def empty(cls, topic: str) -> "Slice":
        """Return an empty slice."""
        return cls(topic, numpy.empty(0, numpy.int64), [])


class FirstMessage(NamedTuple):
    """Early message of a topic, with its layout.

    :param layout: its layout
    :param data: the serialized message
    """

    layout: message_layout.MessageLayout
    data: bytes


def first_messages(bag: Recording) -> Dict[str, FirstMessage]:
    """Return one of the first messages of each readable topic, by global name.

    Other topics are added to ``faults`` of the bag.
    """
    types: Dict[str, Dict[Optional[str], str]] = {}
    for topic, header in bag.connections.values():
        types.setdefault(topic, {})[header.get("md5sum")] = header.get("type", "")
    for topic, names in types.items():
        if len(names) > 1:
            text = "its messages change their type: " + ", ".join(sorted(set(names.values())))
            bag.faults.setdefault(topic, text)
    found: Dict[str, FirstMessage] = {}
    for number, data in bag.earliest().items():
        topic, header = bag.connections[number]
        text = header.get("message_definition", "")
        try:
            layout = message_layout.parse(header.get("type", ""), text)
        except message_layout.DefinitionError as error:
            bag.faults.setdefault(topic, f"its definition cannot be read: {error}")
        if topic not in bag.faults:
            found[topic] = FirstMessage(layout, data)
    return found


def slices(
    bag: Recording, topics: Collection[str], start: int = 0, end: Optional[int] = None
) -> Iterator[List[Slice]]:
    """Read the messages of some topics, about a chunk at a time; damaged chunks are left out.

    Damaged chunks are added to ``lost`` of the bag.

    :param topics: global names
    :param start: start of the time range, since the start of the bag [ns]
    :param end: its end; None for the end of the bag
    :returns: lists of slices in time order, with at most one slice of each topic
    """
    wanted = bag.numbers_of(topics)
    first = bag.start + start
    last = bag.end if end is None else min(bag.start + end, bag.end)
    numbers, starts = bag.chunks_after(first - 1)
    waiting: List[ConnectionMessages] = []
    for number, known_until in zip(numbers, [*starts[1:], last + 1]):
        try:
            waiting += bag.read(number, wanted)
        except BagError as error:
            bag.lost.append(str(error))
        until = min(known_until, last + 1)
        yield _sliced(bag, waiting, first, until)
        if known_until > last:
            return
        waiting = [part.between(until, bag.end + 1) for part in waiting]
        waiting = [part for part in waiting if part.messages]


def _sliced(bag: Recording, parts: List[ConnectionMessages], start: int, end: int) -> List[Slice]:
    """Join the messages of each topic from a start up to, but excluding, an end [ns]."""
    of_topic: Dict[str, List[ConnectionMessages]] = {}
    for part in parts:
        part = part.between(start, end)
        if part.messages:
            of_topic.setdefault(bag.connections[part.connection].topic, []).append(part)
    found_slices = []
    for topic, found in of_topic.items():
        times = numpy.concatenate([part.times for part in found])
        messages = [message for part in found for message in part.messages]
        order = numpy.argsort(times, kind="stable")
        in_order = [messages[index] for index in order.tolist()]
        found_slices.append(Slice(topic, times[order] - bag.start, in_order))
    return found_slices
