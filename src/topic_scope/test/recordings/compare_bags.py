#!/usr/bin/env python3
"""Comparison of each value of recordings, as the scope and the library rosbags read them.

Usage: ci/exec python3 src/topic_scope/test/recordings/compare_bags.py BAG…

Each BAG is a ROS 1 bag, a .mcap or .db3 file, or the folder of a ROS 2 recording. The exit status
is 1 if a time or a value differs, or if the scope cannot read a recording or a topic. What only
the scope can read is named, and counts as neither.
"""

import pathlib
import sys
from typing import Any, Dict, Iterator, List, NamedTuple, Tuple

from topic_scope.bag import rosbags_library
from topic_scope.bag.columns import all_columns
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.opening import open_bag
from topic_scope.bag.recording import BagError
from topic_scope.messages.decoding import Decoder, ElementMissing
from topic_scope.messages.fields import Key, Path

#: Time since the epoch [ns], and the message.
Message = Tuple[int, Any]


class UnknownToRosbags(Exception):
    """Error of a recording that rosbags cannot read."""


class Comparison(NamedTuple):
    """Result for one recording.

    :param compared: number of compared values
    :param differences: descriptions
    """

    compared: int
    differences: List[str]


def compare(path: str) -> Comparison:
    """Compare a recording's topics, times and values.

    :raises BagError: if the scope cannot read it
    :raises UnknownToRosbags: if rosbags cannot read it
    """
    found, values, faults = read_by_scope(path)
    expected = read_by_rosbags(path)
    compared, differences = 0, [f"{topic}: {text}" for topic, text in faults.items()]
    for topic in sorted(set(expected) - set(faults)):
        messages = expected[topic]
        if sorted(found.get(topic, [])) != sorted(time for time, _ in messages):
            differences.append(f"{topic}: other times")
            continue
        for name, place, read in values.get(topic, []):
            known = sorted(((time, repr(value_in(one, place))) for time, one in messages))
            told = sorted((time, repr(value)) for time, value in zip(found[topic], read))
            compared += len(known)
            wrong = [pair for pair in zip(told, known) if not is_same(*pair)]
            if wrong:
                (_, ours), (_, theirs) = wrong[0]
                differences.append(f"{name}: {len(wrong)} values, first {ours} for {theirs}")
    return Comparison(compared, differences)


def is_same(ours: Tuple[int, str], theirs: Tuple[int, str]) -> bool:
    """Return whether time and value agree: rosbags reads a byte as signed, ROS 2 as unsigned."""
    (when, value), (recorded, known) = ours, theirs
    is_byte = known.startswith("-") and known[1:].isdigit() and value.isdigit()
    return ours == theirs or (when == recorded and is_byte and int(known) + 256 == int(value))


def read_by_scope(
    path: str,
) -> Tuple[Dict[str, List[int]], Dict[str, List[Tuple[str, Path, List[Any]]]], Dict[str, str]]:
    """Return times, values (name, place, value of each message) and faults, of each topic."""
    times: Dict[str, List[int]] = {}
    messages: Dict[str, List[bytes]] = {}
    with open_bag(path) as bag:
        first = first_messages(bag)
        for together in slices(bag, first):
            for one in together:
                times.setdefault(one.topic, []).extend((one.times + bag.start).tolist())
                messages.setdefault(one.topic, []).extend(one.messages)
        faults = {**bag.faults, **{f"part {index}": text for index, text in enumerate(bag.lost)}}
    values: Dict[str, List[Tuple[str, Path, List[Any]]]] = {}
    for column in all_columns(first):
        decoder = Decoder(first[column.topic].layout, column.path)
        read = [decoded(decoder, data) for data in messages[column.topic]]
        values.setdefault(column.topic, []).append((column.name, column.path, read))
    return times, values, faults


def decoded(decoder: Decoder, data: bytes) -> Any:
    """Return a number of a message; None if its array is too short."""
    try:
        return decoder.value(data)
    except ElementMissing:
        return None


def read_by_rosbags(path: str) -> Dict[str, List[Message]]:
    """Return the messages of each topic in order of recording.

    :raises UnknownToRosbags: if it cannot read one
    """
    from rosbags.highlevel import AnyReader, AnyReaderError
    from rosbags.typesys import Stores, get_typestore

    found: Dict[str, List[Message]] = {}
    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        with AnyReader([pathlib.Path(path)], default_typestore=store) as reader:
            for connection, time, data in reader.messages():
                message = reader.deserialize(data, connection.msgtype)
                topic = "/" + connection.topic.lstrip("/")  # old bags hold relative names too
                found.setdefault(topic, []).append((time, message))
    except (AnyReaderError, KeyError) as error:
        raise UnknownToRosbags(" ".join(str(error).split())) from None
    return found


def value_in(message: Any, path: Path) -> Any:
    """Return the number at a path of a message of rosbags, as the scope has it."""
    for part in path:
        if isinstance(part, Key):
            continue  # the index before it denotes the element
        if isinstance(part, int):
            if part >= len(message):
                return None
            message = message[part]
        else:
            # ROS 1's seq is not in ROS 2; the scope shows zeros there.
            message = getattr(message, part, 0) if part == "seq" else getattr(message, part)
    if hasattr(message, "nanosec"):
        return message.sec * 10**9 + message.nanosec
    return message.item() if hasattr(message, "item") else message


def lines(paths: List[str]) -> Iterator[Tuple[str, bool]]:
    """Compare recordings; yield a line of text on each, and whether it is equal."""
    for path in paths:
        name = pathlib.Path(path).name
        try:
            result = compare(path)
        except BagError as error:
            yield f"{name}: not read: {error}", False
        except UnknownToRosbags as error:
            yield f"{name}: not compared, rosbags cannot read it: {error}", True
        else:
            yield f"{name}: {result.compared} values compared", not result.differences
            yield from ((f"  {text}", False) for text in result.differences)


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    rosbags_library.fetch()
    rosbags_library.enter()
    equal = True
    for text, is_equal in lines(sys.argv[1:]):
        print(text, flush=True)
        equal = equal and is_equal
    sys.exit(0 if equal else 1)
