"""ROS 2 recordings, written and read by rosbags."""

from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

#: Start of all recordings, since the epoch [ns]: a time that a float cannot represent exactly.
BEGIN = 1700000000123456789
#: Type whose fields need alignment in CDR.
ODD = "odd_msgs/msg/Odd"
ODD_DEFINITION = """\
uint8 IDLE=0
uint8 MOVING=1
string WORD=a<=2
std_msgs/Header header
bool flag
float64 value
string<=20 text
int64[3] three
byte raw
uint16[] many
builtin_interfaces/Duration[] waits
string[<=4] name
float32[<=4] position
odd_msgs/Empty[2] nothing
char last
===============================================================================
MSG: odd_msgs/Empty
===============================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===============================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
===============================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
""".replace("=" * 79, "=" * 80)

#: Topic, type, message and time since the start [ns].
BagMessage = Tuple[str, str, Any, int]


def store() -> Any:
    """Return the types of the recordings."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    made = get_typestore(Stores.ROS2_HUMBLE)
    parsed = get_types_from_msg(ODD_DEFINITION, ODD)
    made.register({name: one for name, one in parsed.items() if name.startswith("odd_msgs")})
    return made


def write(path: Path, sent: Sequence[BagMessage], storage: str = "MCAP", compress: str = "") -> str:
    """Write a recording.

    :param path: the folder that is made
    :param sent: the messages
    :param storage: ``MCAP`` or ``SQLITE3``
    :param compress: ``MESSAGE`` or ``STORAGE``, by zstd; empty for nothing
    :returns: the path as text
    """
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    types, connections = store(), {}
    writer = Writer(path, version=9, storage_plugin=StoragePlugin[storage])
    if compress:
        writer.set_compression(CompressionMode[compress], CompressionFormat.ZSTD)
    with writer:
        for topic, name, message, time in sent:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=types)
            data = types.serialize_cdr(message, name)
            writer.write(connections[topic], BEGIN + time, data)
    return str(path)


def messages(count: int = 40) -> List[BagMessage]:
    """Return messages of three topics, ten a second."""
    import numpy

    types = store().types
    time_type = types["builtin_interfaces/msg/Time"]
    duration, header = types["builtin_interfaces/msg/Duration"], types["std_msgs/msg/Header"]
    sent: List[BagMessage] = []
    for index in range(count):
        time = index * 10**8
        stamp = header(time_type(*divmod(BEGIN + time - 2 * 10**6, 10**9)), "base")
        sent.append(
            ("/x", "std_msgs/msg/Float64", types["std_msgs/msg/Float64"](0.5 * index), time)
        )
        odd = types[
            ODD
        ](
            header=stamp,
            flag=index % 2 == 1,
            value=index / 3.0,
            text="t" * (index % 7),
            three=numpy.array([index, -index, 2**60 + index]),
            raw=-56,  # rosbags' value of a byte, which is 200 in ROS 2
            many=numpy.arange(index % 5, dtype=numpy.uint16),
            waits=[duration(-1, 5 * 10**8)] * (index % 3),
            name=["arm", "leg"][: 1 + index % 2],
            position=numpy.arange(1 + index % 2, dtype=numpy.float32) + index,
            nothing=[types["odd_msgs/msg/Empty"]()] * 2,
            last=index,
        )
        sent.append(("/odd", ODD, odd, time + 10))
        if index % 10 == 3:
            word = types["std_msgs/msg/Int64"](2**53 + 1 + index)
            sent.append(("/rare", "std_msgs/msg/Int64", word, time + 20))
    return sent


def by_topic(sent: Sequence[BagMessage]) -> Dict[str, List[Tuple[int, Any]]]:
    """Return time since the start [ns] and message, of each topic."""
    found: Dict[str, List[Tuple[int, Any]]] = {}
    for topic, _, message, time in sent:
        found.setdefault(topic, []).append((time, message))
    return found
