"""Reader of ROS 1 bags, chunk by chunk, so that a large bag takes little memory.

A bag is a sequence of chunks, each followed by its index. On opening, rosbag.Bag reads and keeps
all indices: 6 s and 98 MB for 400 000 messages. This reader keeps only the positions and times of
the chunks: 0.6 ms and 0.1 MB. Messages are not deserialised. The format:
http://wiki.ros.org/Bags/Format/2.0.
"""

import bz2
import os
import struct
from typing import Collection, Dict, Iterable, List, Mapping, NamedTuple, Tuple

import numpy

from topic_scope.bag.recording import BagError, Connection, ConnectionMessages, Recording

#: First bytes of all bags, and of bags of the supported version.
_ANY, _MAGIC = b"#ROSBAG V", b"#ROSBAG V2.0\n"
#: First bytes of the file that a clone has in place of a large file, without Git LFS.
_POINTER = b"version https://git-lfs"
#: Op codes of the types of records.
_OPERATIONS = {"file": 3, "index": 4, "chunk": 5, "chunk info": 6, "connection": 7}
_U32, _U64, _TIME = struct.Struct("<I"), struct.Struct("<Q"), struct.Struct("<II")
#: Index entry: seconds and nanoseconds of the time, and the offset of the message in its chunk.
_ENTRY = numpy.dtype([("s", "<u4"), ("ns", "<u4"), ("offset", "<u4")])
#: Exceptions that damaged data may cause.
_ERRORS = (OSError, EOFError, LookupError, MemoryError, ValueError, struct.error)


class RecordHeader(NamedTuple):
    """Header of a record.

    :param fields: fields of the header
    :param length: length of the data that follow [bytes]
    """

    fields: Mapping[str, bytes]
    length: int


class Ros1Recording(Recording):
    """Open ROS 1 bag.

    :param path: the file
    :raises BagError: if it cannot be read, or has no messages
    """

    def __init__(self, path: str) -> None:
        super().__init__(path)
        try:
            self._file = open(path, "rb")
        except OSError as error:
            raise BagError(f"{path}: {os.strerror(error.errno or 0)}") from error
        try:
            self._read_index()
        except _ERRORS as error:
            self.close()
            raise self.broken(error) from error
        except BagError:
            self.close()
            raise
        self.start = int(self._chunks["start"].min())
        self.end = int(self._chunks["end"].max())

    def _read_index(self) -> None:
        version = self._file.readline(80)
        if version.startswith(_POINTER):
            raise BagError(f"{self.path} only points to a bag; fetch the bag by: git lfs pull")
        if not version.startswith(_ANY):
            raise BagError(f"{self.path} is not a bag")
        if version != _MAGIC:
            shown = version.decode("ascii", "replace").strip()
            raise BagError(f"{self.path} begins with {shown}: only bags of version 2.0 can be read")
        self._size = self._file.seek(0, 2)
        self._file.seek(len(_MAGIC))
        fields, length = self._record("file")
        if "encryptor" in fields and fields["encryptor"]:
            raise BagError(f"{self.path} is encrypted; decrypt it by: rosbag decrypt")
        if _number(fields, "index_pos", _U64) == 0:
            raise BagError(
                f"{self.path} has no index because its recording was cut off; make one: "
                f"rosbag reindex {self.path}"
            )
        self._file.seek(_number(fields, "index_pos", _U64))
        known: Dict[int, Connection] = {}
        for _ in range(_number(fields, "conn_count")):
            head, length = self._record("connection")
            said = {
                name: value.decode("utf-8", "replace")
                for name, value in _fields(self._read(length)).items()
            }
            topic = "/" + head["topic"].decode("utf-8", "replace").lstrip("/")
            known[_number(head, "conn")] = Connection(topic, said)
        chunks: List[Tuple[int, int, int, int]] = []
        #: Positions of the chunks with messages of a connection, by its number.
        self._holding: Dict[int, List[int]] = {}
        for _ in range(_number(fields, "chunk_count")):
            head, length = self._record("chunk info")
            counts = numpy.frombuffer(self._read(length), "<u4").reshape(-1, 2)
            place = _number(head, "chunk_pos", _U64)
            span = _time(head, "start_time"), _time(head, "end_time")
            chunks.append((place, *span, len(counts)))
            for one, count in counts[counts[:, 1] > 0].tolist():
                self._holding.setdefault(one, []).append(place)
                self._counts[one] = self._counts.get(one, 0) + count
        names = [(name, "i8") for name in ("position", "start", "end", "connections")]
        self._chunks = numpy.sort(numpy.array(chunks, names), order="start")
        self.connections = {number: known[number] for number in sorted(self._holding)}
        if not self.connections:
            raise BagError(f"{self.path} holds no messages")

    def earliest(self) -> Dict[int, bytes]:
        """Read an early message of each topic; see :meth:`.Recording.earliest`."""
        found: Dict[int, bytes] = {}
        waiting = {one.topic for one in self.connections.values()}
        after, last = dict.fromkeys(waiting, -1), dict.fromkeys(waiting, "")
        while waiting:
            by_chunk: Dict[int, List[int]] = {}
            for topic in sorted(waiting):
                places = [
                    (chunk, number)
                    for number in self.numbers_of([topic])
                    for chunk in self._chunks_with(number, after[topic])[:1]
                ]
                if places:
                    chunk, number = min(places)
                    by_chunk.setdefault(chunk, []).append(number)
                    after[topic] = chunk
                else:
                    waiting.remove(topic)
                    self.faults[topic] = last[topic]
            for chunk, numbers in sorted(by_chunk.items()):
                try:
                    parts = [part for part in self.read(chunk, numbers) if part.messages]
                except BagError as error:
                    last.update((self.connections[one].topic, str(error)) for one in numbers)
                    continue
                # A damaged message has no bytes; neither has a valid message without fields.
                found.update(
                    (part.connection, next(filter(None, part.messages), b"")) for part in parts
                )
                waiting -= {self.connections[part.connection].topic for part in parts}
        return found

    def _chunks_with(self, connection: int, after: int) -> List[int]:
        """Return the numbers of the chunks with messages of a connection, after a given chunk."""
        holding = numpy.isin(self._chunks["position"][after + 1 :], self._holding[connection])
        return (numpy.flatnonzero(holding) + after + 1).tolist()

    def chunks_after(self, time: int, last: Iterable[int] = ()) -> "Tuple[List[int], List[int]]":
        """Return the chunks with messages later than a time; see :class:`.Recording`."""
        counts = self._chunks["end"] > time
        over = numpy.flatnonzero(~counts)
        for one in last:
            holding = numpy.isin(self._chunks["position"][over], self._holding[one])
            counts[over[holding][-1:]] = True
        numbers = numpy.flatnonzero(counts)
        return numbers.tolist(), self._chunks["start"][numbers].tolist()

    def read(self, number: int, wanted: Collection[int]) -> List[ConnectionMessages]:
        """Read the messages of some connections in a chunk; see :class:`.Recording`."""
        try:
            return self._read_chunk(self._chunks[number], wanted)
        except _ERRORS as error:
            raise self.broken(error) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def broken(self, error: Exception) -> BagError:
        """Return the exception for a damaged bag.

        :param error: the cause
        """
        reason = str(error) or type(error).__name__
        text = "%s is damaged (%s); recover its messages by: rosbag reindex %s"
        return BagError(text % (self.path, reason, self.path))

    def _read_chunk(self, chunk: numpy.void, wanted: Collection[int]) -> List[ConnectionMessages]:
        self._file.seek(int(chunk["position"]))
        head, length = self._record("chunk")
        start = self._file.tell()
        self._file.seek(start + length)
        entries = self._read_entries(int(chunk["connections"]), wanted)
        if not entries:
            return []
        self._file.seek(start)
        data = self._unpacked(self._read(length), head)
        return [_part(data, connection, found) for connection, found in entries.items()]

    def _read_entries(self, connections: int, wanted: Collection[int]) -> Dict[int, numpy.ndarray]:
        """Read the index that follows a chunk: a record for each connection."""
        entries: Dict[int, numpy.ndarray] = {}
        for _ in range(connections):
            head, length = self._record("index")
            if _number(head, "conn") in wanted:
                entries[_number(head, "conn")] = numpy.frombuffer(self._read(length), _ENTRY)
            else:
                self._file.seek(length, 1)
        return entries

    def _unpacked(self, data: bytes, head: Mapping[str, bytes]) -> bytes:
        how, size = head["compression"].decode(), _number(head, "size")
        if how == "bz2":
            data = bz2.BZ2Decompressor().decompress(data, size + 1)
        elif how == "lz4":
            try:
                import roslz4
            except ModuleNotFoundError:
                text = f"{self.path} is compressed by lz4: apt install python3-roslz4"
                raise BagError(text) from None
            data = roslz4.decompress(data)
        elif how != "none":
            raise ValueError(f"a chunk is compressed by {how}, which is unknown")
        if len(data) != size:
            raise ValueError("a chunk does not have the size that it states")
        return data

    def _record(self, kind: str = "") -> RecordHeader:
        """Read the header of a record.

        :param kind: expected type of record; empty for any
        """
        fields = _fields(self._read(_U32.unpack(self._read(4))[0]))
        if kind and fields["op"] != bytes([_OPERATIONS[kind]]):
            raise ValueError(f"unexpected record, not a {kind}")
        return RecordHeader(fields, _U32.unpack(self._read(4))[0])

    def _read(self, length: int) -> bytes:
        if length > self._size:  # checked before memory is allocated
            raise EOFError("the file ends too early")
        data = self._file.read(length)
        if len(data) != length:
            raise EOFError("the file ends too early")
        return data


def _fields(data: bytes) -> Dict[str, bytes]:
    """Parse a header: fields of the form name=value, each preceded by its length."""
    fields, at = {}, 0
    while at < len(data):
        (length,) = _U32.unpack_from(data, at)
        name, equals, value = data[at + 4 : at + 4 + length].partition(b"=")
        if not equals:
            raise ValueError("a field of a header has no value")
        fields[name.decode("ascii", "replace")] = value
        at += 4 + length
    return fields


def _number(fields: Mapping[str, bytes], name: str, form: struct.Struct = _U32) -> int:
    return int(form.unpack(fields[name])[0])


def _time(fields: Mapping[str, bytes], name: str) -> int:
    seconds, nanoseconds = _TIME.unpack(fields[name])
    return int(seconds) * 10**9 + int(nanoseconds)


def _part(data: bytes, connection: int, entries: numpy.ndarray) -> ConnectionMessages:
    times = entries["s"].astype(numpy.int64) * 10**9 + entries["ns"]
    order = numpy.argsort(times, kind="stable")
    messages = [_message_or_nothing(data, at) for at in entries["offset"][order].tolist()]
    return ConnectionMessages(connection, times[order], messages)


def _message_or_nothing(data: bytes, offset: int) -> bytes:
    """Return a message; empty for a damaged message, which counts as cut off."""
    try:
        return _message(data, offset)
    except (EOFError, struct.error):
        return b""


def _message(data: bytes, offset: int) -> bytes:
    """Return a message: the data of a record; its header only repeats the index."""
    start = offset + 4 + _U32.unpack_from(data, offset)[0]
    (length,) = _U32.unpack_from(data, start)
    message = data[start + 4 : start + 4 + length]
    if len(message) != length:
        raise EOFError("a message ends too early")
    return message
