"""ROS 2 recordings, read by the library rosbags: MCAP and SQLite, files and folders.

Messages and definitions are converted to ROS 1, so that decoding, plots and playback handle one
format. A chunk is a time span here, of about the size of a chunk of a file.
"""

import bisect
import hashlib
import itertools
import os
import pathlib
from typing import Any, Collection, Dict, Iterable, Iterator, List, Mapping, Set, Tuple

import numpy
import yaml

from topic_scope.bag import rosbags_library
from topic_scope.bag.recording import BagError, Connection, ConnectionMessages, Recording
from topic_scope.bag.ros2_types import Ros2Type, TypeProblem

#: Approximate size of a span [bytes], and its number of messages.
_SPAN_BYTES, _SPAN_MESSAGES = 4 * 2**20, 4000
#: Number of messages of a topic to try until one fits its definition.
_FIRST_MESSAGES = 1000
#: Replacement for an unreadable message: a message that is cut off.
_CUT_OFF = b""
#: First bytes of data that is compressed by zstd: RFC 8878, section 3.1.1.
_ZSTD = b"\x28\xb5\x2f\xfd"


class Ros2Recording(Recording):
    """Open ROS 2 recording.

    Each file of a folder is read separately: times and topics in ``metadata.yaml`` may differ
    from the contents of the files.

    :param path: a file, or a folder of such files
    :raises BagError: if it cannot be read, or has no messages
    """

    def __init__(self, path: str) -> None:
        super().__init__(path)
        try:
            rosbags_library.enter()
            from rosbags.rosbag2 import Reader
        except ModuleNotFoundError:
            raise BagError(
                f"{path} is a ROS 2 recording; fetch the library rosbags to read it: "
                f"{rosbags_library.COMMAND}"
            ) from None
        self._metadata = _metadata(path)
        _check_compression(path, self._metadata)
        self._readers: List[Any] = []
        self._sources: Dict[int, Tuple[Any, Any]] = {}
        self._numbers: Dict[Tuple[int, int], int] = {}
        self._types: Dict[int, Ros2Type] = {}
        self._misfits: Set[str] = set()
        files = _files(path, self._metadata)
        try:
            for file in files:
                reader = Reader(file)
                reader.open()
                self._readers.append(reader)
            self._learn()
        except BagError:
            self.close()
            raise
        except Exception as error:  # the library may raise anything for invalid files
            self.close()
            raise self._broken(error) from error
        size = sum(os.path.getsize(str(file)) for file in files)
        self._edges = self._edges_of(size)

    def _learn(self) -> None:
        """Read topics, types and times."""
        full = [one for one in self._readers if one.message_count]
        if not full:
            raise BagError(f"{self.path} holds no messages")
        self._readers.sort(key=lambda one: one.start_time)
        self.start = min(one.start_time for one in full)
        self.end = max(one.end_time for one in full) - 1
        made: Dict[Tuple[str, str], Ros2Type] = {}
        for place, reader in enumerate(self._readers):
            _check_index(reader)
            for one in reader.connections:
                if one.msgcount:
                    number = len(self._sources)
                    self._sources[number], self._numbers[place, one.id] = (reader, one), number
                    self._counts[number] = one.msgcount
                    self.connections[number] = self._connection(number, one, made)

    def _edges_of(self, size: int) -> List[int]:
        """Return the starts of the time spans, and the end of the last [ns]."""
        messages = sum(one.message_count for one in self._readers)
        count = max(1, size // _SPAN_BYTES, messages // _SPAN_MESSAGES)
        if any(_chunks(one) == [] for one in self._readers):
            count = 1  # reading a span of a file without chunks scans the whole file
        whole = self.end + 1 - self.start
        edges = {self.start + whole * index // count for index in range(count + 1)}
        return sorted(edges)

    def _connection(
        self, number: int, source: Any, made: Dict[Tuple[str, str], Ros2Type]
    ) -> Connection:
        topic = "/" + source.topic.lstrip("/")
        language, text = source.msgdef.format.name, source.msgdef.data
        key = source.msgtype, text
        try:
            if source.ext.serialization_format != "cdr":
                raise TypeProblem(f"its messages are in {source.ext.serialization_format}, not CDR")
            if key not in made:
                distribution = _text(self._metadata, "ros_distro")
                made[key] = Ros2Type(source.msgtype, language, text, distribution)
        except TypeProblem as problem:
            self.faults[topic] = f"its definition cannot be read: {problem}"
            return Connection(topic, {"type": source.msgtype})
        self._types[number] = made[key]
        definition = made[key].definition
        digest = hashlib.md5(definition.encode()).hexdigest()
        header = {"type": made[key].name, "md5sum": digest, "message_definition": definition}
        return Connection(topic, header)

    def earliest(self) -> Dict[int, bytes]:
        """Read an early message of each topic; see :meth:`.Recording.earliest`."""
        found: Dict[int, bytes] = {}
        for topic in {one.topic for one in self.connections.values()} - set(self.faults):
            for number in self.numbers_of([topic]):
                reader, source = self._sources[number]
                problem = "the index of the recording lacks its messages"
                try:
                    some = itertools.islice(reader.messages([source]), _FIRST_MESSAGES)
                    for _, _, data in some:
                        try:
                            found[number] = self._types[number].to_ros1(_decompressed(data))
                            break
                        except TypeProblem as error:
                            problem = f"no early message fits its definition: {error}"
                except Exception as error:  # the library may raise anything for invalid files
                    problem = f"its messages cannot be read: {error}"
                if number in found:
                    break
            else:
                self.faults[topic] = problem
        return found

    def chunks_after(self, time: int, last: Iterable[int] = ()) -> "Tuple[List[int], List[int]]":
        """Return the chunks with messages later than a time; see :class:`.Recording`."""
        first = len(self._edges) - 1
        if time < self.end:
            first = max(bisect.bisect_right(self._edges, time) - 1, 0)
        numbers = set(range(first, len(self._edges) - 1))
        for one in last:
            numbers.update(self._latest_before(first, one))
        return sorted(numbers), [self._edges[number] for number in sorted(numbers)]

    def _latest_before(self, first: int, connection: int) -> List[int]:
        """Return the last earlier chunk with a message of a connection, if any."""
        for number in reversed(range(first)):
            try:
                if next(self._messages(number, [connection]), None) is not None:
                    return [number]
            except Exception:  # reading the chunk reports it
                return [number]
        return []

    def read(self, number: int, wanted: Collection[int]) -> List[ConnectionMessages]:
        """Read the messages of some connections in a chunk; see :class:`.Recording`."""
        found: Dict[int, Tuple[List[int], List[bytes]]] = {}
        try:
            for connection, time, data in self._messages(number, wanted):
                times, messages = found.setdefault(connection, ([], []))
                times.append(time)
                messages.append(self._converted(connection, data))
        except Exception as error:  # the library may raise anything for invalid files
            raise self._broken(error) from error
        # The library sorts the messages of a file by time.
        return [
            ConnectionMessages(connection, numpy.array(times, numpy.int64), messages)
            for connection, (times, messages) in found.items()
        ]

    def _messages(self, number: int, wanted: Collection[int]) -> Iterator[Tuple[int, int, bytes]]:
        """Return connection number, time [ns] and bytes of the messages in a chunk."""
        start, end = self._edges[number], self._edges[number + 1]
        for place, reader in enumerate(self._readers):
            mine = [self._sources[one] for one in wanted if one in self._types]
            sources = [source for other, source in mine if other is reader]
            if sources and reader.start_time < end and start < reader.end_time:
                for source, time, data in reader.messages(sources, start, end):
                    yield self._numbers[place, source.id], time, data

    def _converted(self, connection: int, data: bytes) -> bytes:
        try:
            return self._types[connection].to_ros1(_decompressed(data))
        except TypeProblem as problem:
            topic = self.connections[connection].topic
            if topic not in self._misfits:
                self._misfits.add(topic)
                text = "messages that do not fit their definition are left out"
                self.notes.append(f"{self.path}: {topic}: {text}: {problem}")
            return _CUT_OFF

    def close(self) -> None:
        """Close the files."""
        for reader in self._readers:
            reader.close()

    def _broken(self, error: Exception) -> BagError:
        reason = str(error) or type(error).__name__
        return BagError(f"{self.path} cannot be read: {reason}")


def _metadata(path: str) -> Dict[str, Any]:
    """Return the contents of ``metadata.yaml``, in a folder or beside a file; empty without one."""
    folder = path if os.path.isdir(path) else os.path.dirname(path)
    try:
        with open(os.path.join(folder, "metadata.yaml"), encoding="utf-8") as file:
            found = dict(yaml.safe_load(file)["rosbag2_bagfile_information"])
            named = [os.path.basename(one) for one in found["relative_file_paths"]]
            return found if folder == path or os.path.basename(path) in named else {}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, LookupError, TypeError, yaml.YAMLError) as error:
        if folder != path:
            return {}
        raise BagError(f"{path}: its metadata.yaml cannot be read: {error}") from error


def _files(path: str, metadata: Mapping[str, Any]) -> List[pathlib.Path]:
    """Return the files of a recording."""
    folder = pathlib.Path(path)
    if not folder.is_dir():
        return [folder]
    named = [folder / os.path.basename(one) for one in metadata.get("relative_file_paths", [])]
    missing = [one.name for one in named if not one.exists()]
    if missing:
        raise BagError(f"{path}: {missing[0]} is missing, which its metadata.yaml names")
    # A killed recorder has not written the names of its last files.
    others = {*folder.glob("*.mcap"), *folder.glob("*.db3")} - set(named)
    return [*named, *sorted(others)]


def _text(metadata: Mapping[str, Any], name: str) -> str:
    """Return a string of ``metadata.yaml``; empty for other types, which may be recursive."""
    value = metadata.get(name)
    return value if isinstance(value, str) else ""


def _check_compression(path: str, metadata: Mapping[str, Any]) -> None:
    """Reject a compression other than none, or zstd for each message.

    :raises BagError: if the compression is another one
    """
    mode = _text(metadata, "compression_mode").lower() or "none"
    form = _text(metadata, "compression_format")
    if mode != "none" and (mode != "message" or form != "zstd"):
        raise BagError(
            f"{path}: its files are compressed by {form}; convert it by: ros2 bag convert"
        )


def _decompressed(data: bytes) -> bytes:
    """Return the bytes of a message, decompressed if its first bytes say so: CDR begins with 0.

    Thus a file is read without its ``metadata.yaml``, too.

    :raises TypeProblem: if it cannot be decompressed
    """
    if data[:4] != _ZSTD:
        return data
    from rosbags.rosbag2.storage_mcap import zstd

    try:
        unpacked: bytes = zstd.decompress(data)
    except Exception as error:  # of a type of its own in each version of Python
        raise TypeProblem(f"it cannot be decompressed: {error}") from error
    return unpacked


def _chunks(reader: Any) -> Any:
    """Return the chunk index of a file; None if its format has no chunks."""
    return getattr(reader.storage, "chunks", None)


def _check_index(reader: Any) -> None:
    """Reject a file without an index of its messages: rosbags would find no messages.

    :raises BagError: if the index is missing
    """
    chunks = _chunks(reader) or []
    known = sum(sum(one.channel_count.values()) for one in chunks)
    if chunks and known < reader.message_count:
        text = "has no index of its messages; make one by: mcap recover"
        raise BagError(f"{reader.path} {text}")
