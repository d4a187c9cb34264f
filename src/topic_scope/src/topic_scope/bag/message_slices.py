"""The messages of a bag, topic by topic, in the order of time."""

from typing import Collection, Dict, Iterator, List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.bag.file import BagError, BagFile, Part
from topic_scope.messages import definitions


class Slice(NamedTuple):
    """Messages of one topic.

    :param topic: its global name
    :param times: when they were recorded, ascending, since the start of the bag [ns]
    :param messages: as they were sent
    """

    topic: str
    times: numpy.ndarray
    messages: List[bytes]

    @classmethod
    def empty(cls, topic: str) -> "Slice":
        """Return no messages."""
        return cls(topic, numpy.empty(0, numpy.int64), [])


class FirstMessage(NamedTuple):
    """The message of a topic that tells what there is in it.

    :param layout: its layout
    :param data: the message as it was sent
    """

    layout: definitions.Record
    data: bytes


def first_messages(bag: BagFile) -> Dict[str, FirstMessage]:
    """Return one of the first messages of each topic, by global name.

    :raises BagError: if a part of the bag is broken
    """
    firsts: Dict[str, Tuple[int, int]] = {}
    for number, connection in bag.connections.items():
        place = (bag.first_chunk(number), number)
        firsts[connection.topic] = min(place, firsts.get(connection.topic, place))
    by_chunk: Dict[int, List[int]] = {}
    for chunk, number in sorted(firsts.values()):
        by_chunk.setdefault(chunk, []).append(number)
    found: Dict[str, FirstMessage] = {}
    for chunk, numbers in by_chunk.items():
        for part in bag.read(chunk, numbers):
            topic, header = bag.connections[part.connection]
            try:
                layout = definitions.parse(
                    header.get("type", ""), header.get("message_definition", "")
                )
            except definitions.DefinitionError as error:
                raise bag.broken(error) from error
            if part.messages:
                found[topic] = FirstMessage(layout, part.messages[0])
    return found


def slices(
    bag: BagFile, topics: Collection[str], start: int = 0, end: Optional[int] = None
) -> Iterator[List[Slice]]:
    """Read the messages of some topics, a chunk or so at a time.

    :param topics: global names
    :param start: time of the first one, since the start of the bag [ns]
    :param end: time of the last one; None for the end of the bag
    :returns: slices of the topics, at most one of each; what comes later in time comes later
    :raises BagError: if a part of the bag is broken, or a topic changes its type
    """
    wanted = bag.numbers_of(topics)
    said = [bag.connections[number] for number in wanted]
    types = {(one.topic, one.header.get("md5sum")) for one in said}
    for topic in topics:
        if sum(name == topic for name, _ in types) > 1:
            raise BagError(f"{bag.path}: the messages of {topic} change their type")
    first = bag.start + start
    last = bag.end if end is None else min(bag.start + end, bag.end)
    numbers, starts = bag.chunks_after(first - 1)
    waiting: List[Part] = []
    for number, known_until in zip(numbers, [*starts[1:], last + 1]):
        waiting += bag.read(number, wanted)
        until = min(known_until, last + 1)
        yield _sliced(bag, waiting, first, until)
        if known_until > last:
            return
        waiting = [part.between(until, bag.end + 1) for part in waiting]
        waiting = [part for part in waiting if part.messages]


def _sliced(bag: BagFile, parts: List[Part], start: int, end: int) -> List[Slice]:
    """Put together what parts hold of each topic from one time to before another [ns]."""
    of_topic: Dict[str, List[Part]] = {}
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
