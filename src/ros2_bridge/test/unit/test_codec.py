"""Conversion of serialized messages between both ROSes."""

import io
import struct
import threading
from typing import Any, List

import genpy.dynamic
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodekit.message_definitions import Fields, parse
from ros2_bridge.types.codec import Codec, MappedCodec
from ros2_bridge.types.codec_ops import ConversionError
from ros2_bridge.types.field_mapping import FieldMapping
from ros2_bridge.types.type_pair import FieldRules

SEPARATOR = "\n" + "=" * 80 + "\n"
HEADER = SEPARATOR + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
EVERYTHING = (
    "Header header\nbool[] flags\nint8 a\nfloat64 b\nuint16[3] c\nstring d\nstring[] e\n"
    "inner[] f\ninner[2] g\npoint[] h\ntime i\nduration[] j\nempty k\nempty[] l\n"
    "int64 m\nchar[5] n\nstamped[] o\nstring[2] p\nfloat32[] q\npoint[3] r\n"
    + SEPARATOR
    + "MSG: pkg/inner\nuint8 x\nstring y\nfloat64[] z"
    + SEPARATOR
    + "MSG: pkg/point\nfloat64 x\nfloat64 y"
    + SEPARATOR
    + "MSG: pkg/empty\nint8 NOTHING=1"
    + SEPARATOR
    + "MSG: pkg/stamped\nstd_msgs/Header header\nuint8 x"
    + HEADER
)
NUMBERS = {
    **{"bool": st.booleans(), "float32": st.floats(width=32), "float64": st.floats()},
    **{f"int{n}": st.integers(-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"uint{n}": st.integers(0, 2**n - 1) for n in (8, 16, 32, 64)},
}
WORDS = st.integers(0, 2**32 - 1)


def ros1_bytes(fields: Fields, datatype: str) -> Any:
    """Return a strategy for genpy's serialization of messages of a type."""

    def element(base: str) -> Any:
        if base in ("byte", "char"):
            return NUMBERS["uint8"].map(lambda value: struct.pack("<B", value))
        if base in ("time", "duration"):
            seconds = st.integers(0, 2**31 - 1) if base == "time" else WORDS
            return st.tuples(seconds, WORDS).map(lambda both: struct.pack("<II", *both))
        if base == "string":
            text = st.binary(max_size=9).filter(lambda value: b"\0" not in value)
            return text.map(lambda value: struct.pack("<I", len(value)) + value)
        if base in NUMBERS:
            size = {"bool": "?", "float32": "f", "float64": "d"}.get(base)
            size = size or "bhiq"["8 16 32 64".split().index(base.lstrip("uint"))]
            note = "<" + (size.upper() if base.startswith("u") else size)
            return NUMBERS[base].map(lambda value: struct.pack(note, value))
        return ros1_bytes(fields, base)

    def field(each: Any) -> Any:
        if not each.is_array:
            return element(each.base)
        if each.length is not None:
            return st.tuples(*[element(each.base)] * each.length).map(b"".join)
        several = st.lists(element(each.base), max_size=2)
        return several.map(lambda parts: struct.pack("<I", len(parts)) + b"".join(parts))

    return st.tuples(*map(field, fields[datatype])).map(b"".join)


FIELDS = parse("pkg/all", EVERYTHING)


@given(ros1_bytes(FIELDS, "pkg/all"))
@settings(max_examples=40)
def test_every_field_type_survives_round_trip(data: bytes) -> None:
    codec = Codec("pkg/all", FIELDS)
    cdr = codec.to_cdr(data)
    (seq,) = struct.unpack_from("<I", data)
    back = codec.to_ros1(cdr, seq)
    # The Headers further down have lost their numbers, and only these.
    assert codec.to_cdr(back) == cdr
    assert len(back) == len(data)
    assert codec.to_ros1(cdr, seq) == back
    assert codec.to_ros1(cdr) == b"\0\0\0\0" + back[4:]


@given(st.data())
@settings(max_examples=60)
def test_any_definition_survives_round_trip(data: st.DataObject) -> None:
    bases = [*NUMBERS, "string", "time", "duration", "inner"]
    lines: List[str] = []
    for text in ("inner", "outer"):
        usable = bases if text == "outer" else bases[:-1]
        count = data.draw(st.integers(0, 6))
        kinds = [data.draw(st.sampled_from(usable)) for _ in range(count)]
        arrays = [data.draw(st.sampled_from(["", "[]", "[2]"])) for _ in range(count)]
        lines.append("\n".join(f"{k}{a} f{i}" for i, (k, a) in enumerate(zip(kinds, arrays))))
    text = lines[1] + SEPARATOR + "MSG: pkg/inner\n" + lines[0]
    fields = parse("pkg/outer", text)
    codec = Codec("pkg/outer", fields)
    message = data.draw(ros1_bytes(fields, "pkg/outer"))
    assert codec.to_ros1(codec.to_cdr(message)) == message


def test_as_genpy_writes_it() -> None:
    text = "Header header\nstring[] names\nfloat64[] values\nduration late\n" + HEADER
    cls = genpy.dynamic.generate_dynamic("pkg/sample", text)["pkg/sample"]
    message = cls(names=["a", "bcde"], values=[1.5, -2.5], late=genpy.Duration(-3, 5))
    message.header.seq, message.header.frame_id = 7, "odom"
    message.header.stamp = genpy.Time(1, 2)
    buffer = io.BytesIO()
    message.serialize(buffer)
    cdr = Codec("pkg/sample", parse("pkg/sample", text)).to_cdr(buffer.getvalue())
    assert cdr == (
        b"\0\1\0\0"
        + struct.pack("<IiI5s3x", 1, 2, 5, b"odom")  # stamp, frame_id
        + struct.pack("<II2s2xI5s3x", 2, 2, b"a", 5, b"bcde")
        + struct.pack("<Idd", 2, 1.5, -2.5)  # at a multiple of 8 by itself
        + struct.pack("<iI", -3, 5)
    )


@pytest.mark.parametrize(
    "definition, data, cdr",
    [
        # A message in an array has gaps where its numbers differ in size, and none where not.
        ("uint8 x\nfloat64 y", "<I Bd Bd", "<I B3x d B7x d"),
        ("uint16 x\nuint16 y", "<I HH HH", "<I HH HH"),
        ("empty z\nuint8 x\nuint8 y", "<I BB BB", "<I xBB xBB"),
        ("uint8 x\nempty z\nuint8 y", "<I BB BB", "<I BxB BxB"),
        ("empty z\nuint8 x\nuint32 y", "<I BI BI", "<I xB2xI xB2xI"),
    ],
)
def test_arrays_of_messages(definition: str, data: str, cdr: str) -> None:
    text = f"some[] v{SEPARATOR}MSG: pkg/some\n{definition}{SEPARATOR}MSG: pkg/empty\n"
    codec = Codec("pkg/a", parse("pkg/a", text))
    numbers = (2, 1, 2, 3, 4)
    assert codec.to_cdr(struct.pack(data, *numbers)) == b"\0\1\0\0" + struct.pack(cdr, *numbers)
    assert codec.to_ros1(b"\0\1\0\0" + struct.pack(cdr, *numbers)) == struct.pack(data, *numbers)


@pytest.mark.parametrize(
    "base, data",
    [
        ("some", struct.pack("<IIB", 1, 0, 7)),
        ("Header", struct.pack("<I4I", 1, 0, 1, 2, 0)),
        ("none", struct.pack("<I", 3)),
    ],
)
def test_the_shortest_elements_of_an_array(base: str, data: bytes) -> None:
    parts = f"{SEPARATOR}MSG: pkg/some\nstring x\nuint8 y{SEPARATOR}MSG: pkg/none\n{HEADER}"
    codec = Codec("pkg/a", parse("pkg/a", f"{base}[] v{parts}"))
    assert codec.to_ros1(codec.to_cdr(data)) == data


def test_conversion_error_gives_reason() -> None:
    codec = Codec("pkg/a", parse("pkg/a", "uint8 x"))
    with pytest.raises(ConversionError, match="^pkg/a: 2 bytes too many"):
        codec.to_cdr(b"\1\2\3")
    with pytest.raises(
        ConversionError, match=r"b'(\\x00){4}' is not the start of a little-endian CDR"
    ):
        codec.to_ros1(b"\0\0\0\0\1")
    with pytest.raises(ConversionError, match="9 bytes announced, 1 left"):
        Codec("pkg/a", parse("pkg/a", "string x")).to_cdr(b"\x09\0\0\0x")
    with pytest.raises(ConversionError, match="2 elements announced, 7 bytes left"):
        Codec("pkg/a", parse("pkg/a", "string[] x")).to_cdr(b"\2\0\0\0" + bytes(7))
    with pytest.raises(ConversionError, match="8 elements announced, 7 bytes left"):
        Codec("pkg/a", parse("pkg/a", "string[] x")).to_ros1(b"\0\1\0\0\x08\0\0\0" + bytes(7))


def test_empty_message_has_one_byte_in_ros2() -> None:
    codec = Codec("std_msgs/Empty", parse("std_msgs/Empty", ""))
    assert codec.to_cdr(b"") == b"\0\1\0\0\0"
    assert codec.to_ros1(b"\0\1\0\0\0\0\0\0") == b""


def test_seq_is_that_of_the_topic() -> None:
    text = "Header header\nuint8 x" + HEADER
    codec = Codec("pkg/a", parse("pkg/a", text))
    cdr = codec.to_cdr(struct.pack("<IIIIB", 99, 1, 2, 0, 5))
    assert struct.unpack_from("<I", codec.to_ros1(cdr, 2**32 + 3)) == (3,)
    assert not Codec("pkg/b", parse("pkg/b", "uint32 seq")).has_header
    # The mapping rule leaves out the Header that only ROS 2's type has.
    plain, stamped = parse("a/L", "float64 x"), parse("b/L", "Header header\nfloat64 x" + HEADER)
    rules = {"a/L": FieldRules("b/L", {}, [], ["header"])}
    mapping = FieldMapping("a/L", plain, "b/L", stamped, rules, lambda _: bytes(24))
    mapped, data = MappedCodec(Codec("b/L", stamped), mapping, plain, "a/L"), struct.pack("<d", 2.5)
    assert mapped.to_ros1(mapped.to_cdr(data), 7) == data
    ours = parse("a/M", "Header header\nfloat64 y" + HEADER)
    rules = {"a/M": FieldRules("b/L", {"y": "x"})}
    mapping = FieldMapping("a/M", ours, "b/L", stamped, rules, lambda _: b"")
    mapped = MappedCodec(Codec("b/L", stamped), mapping, ours, "a/M")
    data = struct.pack("<IIIId", 9, 1, 2, 0, 2.5)
    assert mapped.to_ros1(mapped.to_cdr(data), 2**32 + 9) == data


@pytest.mark.parametrize(
    "definition, data, cdr",
    [
        ("string s", b"\xff\xff\xff\xff", b"\0\1\0\0\xff\xff\xff\xff"),
        ("float64[] v", b"\2\0\0\0" + b"\0" * 15, b"\0\1\0\0\2\0\0\0" + b"\0" * 19),
        ("string[] v", b"\xff\xff\xff\xff", b"\0\1\0\0\xff\xff\xff\xff"),
        ("none[] v", b"\xff\xff\xff\xff", b"\0\1\0\0\xff\xff\xff\xff"),
        ("uint32 v", b"\0\0\0", b"\0\1\0\0\0\0\0"),
        ("uint8 v", b"\0\0", b"\0\0\0\0\0"),
    ],
)
def test_malformed_bytes_are_rejected_cheaply(definition: str, data: bytes, cdr: bytes) -> None:
    fields = parse("pkg/a", definition + SEPARATOR + "MSG: pkg/none\n")
    codec = Codec("pkg/a", fields)
    with pytest.raises(ConversionError, match="pkg/a"):
        codec.to_cdr(data)
    with pytest.raises(ConversionError, match="pkg/a"):
        codec.to_ros1(cdr)


def test_codec_is_thread_safe() -> None:
    codec = Codec("pkg/all", parse("pkg/all", "string[] v"))
    wrong: List[int] = []

    def work(number: int) -> None:
        text = struct.pack("<I", number) + b"x" * number
        data = struct.pack("<I", 20) + text * 20
        for _ in range(100):
            if codec.to_ros1(codec.to_cdr(data)) != data:
                wrong.append(number)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


@pytest.mark.parametrize("shape", ["time t", "time[] t", "time[2] t", "Header t", "Header[] t"])
def test_time_that_the_other_ros_lacks_is_refused(shape: str) -> None:
    codec = Codec("pkg/m", parse("pkg/m", shape + HEADER))

    def ros1(seconds: int) -> bytes:
        stamp = struct.pack("<II", seconds, 7)
        one = struct.pack("<I", 0) + stamp + struct.pack("<I", 0) if "Header" in shape else stamp
        many = struct.pack("<I", 1) + one if "[]" in shape else one
        return many + stamp if "[2]" in shape else many

    last = codec.to_cdr(ros1(2**31 - 1))
    assert codec.to_ros1(last) == ros1(2**31 - 1)
    with pytest.raises(ConversionError, match="after 2038-01-19"):
        codec.to_cdr(ros1(2**31))
    with pytest.raises(ConversionError, match="before 1970"):
        codec.to_ros1(last.replace(struct.pack("<i", 2**31 - 1), struct.pack("<i", -1)))
    long = Codec("pkg/m", parse("pkg/m", "duration d"))  # which has a sign in both
    assert long.to_ros1(long.to_cdr(struct.pack("<ii", -1, 5))) == struct.pack("<ii", -1, 5)
