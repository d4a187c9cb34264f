"""Payloads of the special frames (ids below 100), as in ros-drivers/rosserial's rosserial_msgs.

A string is its length (32 bits) and its bytes, as in any ROS message. Payloads that are too long,
or that no board would send, are rejected: an 8-bit checksum misses one damaged frame in 256.
"""

import re
import struct
from typing import List, NamedTuple, Sequence, Tuple

from serial_link.framing.frames import LONGEST

#: Frame ids: PUBLISHER or SUBSCRIBER, added to the id of a kind, announces a topic.
PUBLISHER, SUBSCRIBER = 0, 1
SERVICE_SERVER, SERVICE_CLIENT = 2, 4
PARAMETER, LOG, TIME, STOP = 6, 7, 10, 11
#: Ids that announce a topic, or half of a service.
TOPICS = range(PUBLISHER, SERVICE_CLIENT + SUBSCRIBER + 1)
#: First valid topic id.
FIRST_TOPIC = 100

#: Log levels of a board.
DEBUG, INFO, WARN, ERROR, FATAL = range(5)

_ID, _SIZE, _LENGTH = struct.Struct("<H"), struct.Struct("<i"), struct.Struct("<I")
_TIME = struct.Struct("<II")
#: Most characters of an invalid text in a message.
_SHOWN = 40
_NAME = re.compile(r"[~/]?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*")
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*/[A-Za-z][A-Za-z0-9_]*")
_MD5 = re.compile(r"[0-9a-f]{32}|\*")


class PayloadError(ValueError):
    """A payload that is invalid for its id."""


class TopicInfo(NamedTuple):
    """Announcement of a topic, or of half of a service.

    :param topic_id: the id of its messages' frames
    :param name: of the topic or service
    :param type: of the message or service, ``package/Name``
    :param md5sum: of the message, or of this half of the service
    :param buffer_size: size of the board's buffer [bytes]
    """

    topic_id: int
    name: str
    type: str
    md5sum: str
    buffer_size: int


def encode_topic(info: TopicInfo) -> bytes:
    """Return the payload that announces a topic."""
    texts = b"".join(_text(text) for text in (info.name, info.type, info.md5sum))
    return _ID.pack(info.topic_id) + texts + _SIZE.pack(info.buffer_size)


def decode_topic(payload: bytes) -> TopicInfo:
    """Decode the announcement of a topic.

    :param payload: of a frame
    :returns: the announcement, with surplus slashes removed from the name and the buffer size
        limited to a frame; its texts may be invalid, see :func:`problem_of`
    :raises PayloadError: if it is malformed, or has an invalid topic id
    """
    reader = _Reader(payload)
    (topic_id,) = reader.read(_ID)
    name, datatype, md5sum = reader.text(), reader.text(), reader.text()
    (buffer_size,) = reader.read(_SIZE)
    reader.end()
    if topic_id < FIRST_TOPIC:
        raise PayloadError(f"invalid topic id: {topic_id}")
    return TopicInfo(topic_id, _resolved(name), datatype, md5sum, min(buffer_size, LONGEST))


def problem_of(info: TopicInfo) -> str:
    """Return what the sketch must change, if ROS cannot have the topic; empty if it can.

    :param info: the announcement
    """
    if not _TYPE.fullmatch(info.type) or not _MD5.fullmatch(info.md5sum):
        return (
            f"its type {info.type[:_SHOWN]!r} and md5sum {info.md5sum[:_SHOWN]!r} are not those of "
            "a message; rosserial's Arduino library 0.7.9 reads those of other headers than its "
            "own from the wrong memory: build the sketch with 0.7.8; if it already is, its RAM may "
            "be full"
        )
    if not _NAME.fullmatch(info.name):
        return (
            f"{info.name[:_SHOWN]!r} is not a valid ROS name: in the sketch, use letters, digits, "
            "_ and /, with a letter first"
        )
    if info.buffer_size <= 0:
        return (
            f"its buffer has {info.buffer_size} bytes: in the sketch, give NodeHandle_ buffers of "
            f"1 to {LONGEST} bytes"
        )
    return ""


def encode_log(level: int, text: str) -> bytes:
    """Return the payload of a log line."""
    return bytes((level,)) + _text(text)


def decode_log(payload: bytes) -> Tuple[int, str]:
    """Decode a log line.

    :param payload: of a frame
    :returns: its level and its text
    :raises PayloadError: if it is malformed
    """
    if not payload or payload[0] > FATAL:
        raise PayloadError("invalid log line")
    reader = _Reader(payload[1:])
    text = reader.text()
    reader.end()
    return payload[0], text


def encode_name(name: str) -> bytes:
    """Return a request for a parameter."""
    return _text(name)


def decode_name(payload: bytes) -> str:
    """Decode the name of a requested parameter.

    :param payload: of a frame
    :raises PayloadError: if it is malformed, or no name
    """
    reader = _Reader(payload)
    name = _resolved(reader.text())
    reader.end()
    if not _NAME.fullmatch(name):
        raise PayloadError(f"invalid parameter name: {name!r}")
    return name


class ParameterValues(NamedTuple):
    """Answer to a parameter request: one list per type; the board uses the requested one."""

    ints: Sequence[int] = ()
    floats: Sequence[float] = ()
    texts: Sequence[str] = ()


def encode_values(values: ParameterValues) -> bytes:
    """Return the answer to a request for a parameter.

    :param values: whole numbers of 32 bits, numbers that 32-bit floats hold, and texts
    """
    ints, floats = list(values.ints), list(values.floats)
    texts = [_text(text) for text in values.texts]
    return b"".join(
        (
            struct.pack(f"<I{len(ints)}i", len(ints), *ints),
            struct.pack(f"<I{len(floats)}f", len(floats), *floats),
            _LENGTH.pack(len(texts)),
            *texts,
        )
    )


def decode_values(payload: bytes) -> ParameterValues:
    """Read the answer to a request for a parameter.

    :param payload: of a frame
    :raises PayloadError: if it is malformed
    """
    reader = _Reader(payload)
    ints = reader.numbers("i")
    floats = reader.numbers("f")
    (count,) = reader.read(_LENGTH)
    texts: List[str] = []
    for _ in range(count):
        texts.append(reader.text())
    reader.end()
    return ParameterValues(tuple(map(int, ints)), floats, tuple(texts))


def encode_time(seconds: int, nanoseconds: int) -> bytes:
    """Return a time, or with 0 a request for it."""
    return _TIME.pack(seconds, nanoseconds)


def decode_time(payload: bytes) -> Tuple[int, int]:
    """Read a time, s and ns.

    :param payload: of a frame
    :raises PayloadError: if it is malformed
    """
    reader = _Reader(payload)
    seconds, nanoseconds = reader.read(_TIME)
    reader.end()
    return int(seconds), int(nanoseconds)


def _resolved(name: str) -> str:
    """Return a name without the slashes that ROS ignores: two in a row, and the last."""
    start = name[:1] if name[:1] in ("~", "/") else ""
    return start + "/".join(part for part in name[len(start) :].split("/") if part)


def _text(text: str) -> bytes:
    data = text.encode("utf-8")
    return _LENGTH.pack(len(data)) + data


class _Reader:
    """Sequential reader of a payload's values, which rejects a truncated payload."""

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, 0

    def read(self, form: struct.Struct) -> Tuple[int, ...]:
        place = self._place
        self._place += form.size
        self._check()
        return form.unpack_from(self._data, place)

    def text(self) -> str:
        (size,) = self.read(_LENGTH)
        place = self._place
        self._place += size
        self._check()
        return self._data[place : self._place].decode("utf-8", "replace")

    def numbers(self, kind: str) -> Tuple[float, ...]:
        (count,) = self.read(_LENGTH)
        if count > len(self._data):  # or the format would be of any length
            raise PayloadError(f"truncated payload: {len(self._data)} bytes")
        return self.read(struct.Struct(f"<{count}{kind}"))

    def end(self) -> None:
        if self._place != len(self._data):
            surplus = len(self._data) - self._place
            raise PayloadError(f"surplus bytes after the payload: {surplus}")

    def _check(self) -> None:
        if self._place > len(self._data):
            raise PayloadError(f"truncated payload: {len(self._data)} bytes")
