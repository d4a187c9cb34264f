"""Payloads of the special frames: encoded, decoded, and rejected if implausible."""

import re
import struct
from typing import Any, Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from serial_link.negotiation import payloads
from serial_link.negotiation.payloads import PayloadError, TopicInfo, ParameterValues

names = st.from_regex(r"[~/]?[A-Za-z][A-Za-z0-9_]{0,9}(/[A-Za-z0-9_]{1,9}){0,3}", fullmatch=True)
types = st.from_regex(r"[a-z][a-z0-9_]{0,9}/[A-Z][A-Za-z0-9]{0,9}", fullmatch=True)
sums = st.text("0123456789abcdef", min_size=32, max_size=32)
infos = st.builds(TopicInfo, st.integers(100, 0xFFFF), names, types, sums, st.integers(1, 32767))
DECODERS = [
    payloads.decode_topic,
    payloads.decode_log,
    payloads.decode_name,
    payloads.decode_values,
    payloads.decode_time,
]


@given(infos)
def test_topic_survives_round_trip(info: TopicInfo) -> None:
    assert payloads.decode_topic(payloads.encode_topic(info)) == info


@given(st.integers(0, 4), st.text())
def test_log_line_survives_round_trip(level: int, text: str) -> None:
    text = text.encode("utf-8", "replace").decode()
    assert payloads.decode_log(payloads.encode_log(level, text)) == (level, text)


@given(
    st.lists(st.integers(-(2**31), 2**31 - 1), max_size=4),
    st.lists(st.floats(width=32, allow_nan=False), max_size=4),
    st.lists(st.text(st.characters(blacklist_categories=["Cs"])), max_size=4),
)
def test_parameter_values_survive_round_trip(ints: Any, floats: Any, texts: Any) -> None:
    found = payloads.decode_values(payloads.encode_values(ParameterValues(ints, floats, texts)))
    assert found == (tuple(ints), tuple(floats), tuple(texts))


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_time_survives_round_trip(seconds: int, nanoseconds: int) -> None:
    data = payloads.encode_time(seconds, nanoseconds)
    assert payloads.decode_time(data) == (seconds, nanoseconds)


def test_name_survives_round_trip() -> None:
    assert payloads.decode_name(payloads.encode_name("~gains/kp")) == "~gains/kp"


@pytest.mark.parametrize("decode", DECODERS)
@given(data=st.binary(max_size=60))
def test_any_payload_is_decoded_or_rejected(decode: Callable[[bytes], Any], data: bytes) -> None:
    try:
        decode(data)
    except PayloadError:
        pass


@given(infos, st.integers(0, 10_000))
def test_topic_of_wrong_length_is_rejected(info: TopicInfo, cut: int) -> None:
    payload = payloads.encode_topic(info)
    for wrong in (payload[: cut % len(payload)], payload + b"\0"):
        with pytest.raises(PayloadError):
            payloads.decode_topic(wrong)


@pytest.mark.parametrize(
    "decode, payload",
    [
        (payloads.decode_log, payloads.encode_log(1, "text")),
        (payloads.decode_name, payloads.encode_name("gain")),
        (payloads.decode_values, payloads.encode_values(ParameterValues([1], [1.0], ["a"]))),
        (payloads.decode_time, payloads.encode_time(1, 2)),
    ],
)
def test_payload_of_wrong_length_is_rejected(
    decode: Callable[[bytes], Any], payload: bytes
) -> None:
    surplus = "surplus bytes after the payload: 1$"
    for wrong, why in ((payload[:-1], "truncated"), (payload + b"\0", surplus)):
        with pytest.raises(PayloadError, match=why):
            decode(wrong)


GOOD = TopicInfo(125, "speed", "std_msgs/Float32", "0" * 32, 512)


@pytest.mark.parametrize(
    "wrong, advice",
    [
        ({"name": ""}, "'' is not a valid ROS name"),
        ({"name": "spe ed"}, "'spe ed' is not a valid ROS name"),
        ({"name": "my-topic"}, "'my-topic' is not a valid ROS name: in the sketch, use letters"),
        ({"name": "1st"}, "'1st' .* with a letter first"),
        ({"name": "/"}, "'/' is not a valid ROS name"),
        ({"type": "Float32"}, "type 'Float32' .* build the sketch with 0.7.8"),
        ({"type": "std_msgs/Float32/x"}, "build the sketch with 0.7.8"),
        (
            {"md5sum": "0" * 31},
            "build the sketch with 0.7.8; if it already is, its RAM may be full",
        ),
        ({"md5sum": "G" * 32}, "md5sum 'G"),
        ({"buffer_size": 0}, "0 bytes: in the sketch, give NodeHandle_ buffers of 1 to 32767"),
        ({"buffer_size": -25536}, "-25536 bytes"),
    ],
)
def test_invalid_topic_is_decoded_and_problem_names_remedy(wrong: Any, advice: str) -> None:
    assert payloads.problem_of(GOOD) == ""
    info = GOOD._replace(**wrong)
    assert payloads.decode_topic(payloads.encode_topic(info)) == info
    assert re.search(advice, payloads.problem_of(info))


@given(infos)
def test_topic_of_a_board_has_no_problem(info: TopicInfo) -> None:
    assert payloads.problem_of(info) == ""


def test_type_and_md5sum_that_are_garbage_are_read_and_shown_in_part() -> None:
    payload = payloads.encode_topic(GOOD._replace(type="x" * 16, md5sum="y" * 100))
    info = payloads.decode_topic(payload.replace(b"x" * 16, bytes(range(0x80, 0x90))))
    assert len(payloads.problem_of(info)) < 300 and "0.7.8" in payloads.problem_of(info)


@pytest.mark.parametrize(
    "told, name",
    [("chatter/", "chatter"), ("//a///b//", "/a/b"), ("~/gain", "~gain"), ("~gain", "~gain")],
)
def test_slashes_that_ros_ignores_are_dropped(told: str, name: str) -> None:
    info = GOOD._replace(name=told)
    assert payloads.decode_topic(payloads.encode_topic(info)).name == name
    assert payloads.decode_name(payloads.encode_name(told)) == name


def test_buffer_beyond_a_frame_counts_as_a_frame() -> None:
    payload = payloads.encode_topic(GOOD._replace(buffer_size=40000))
    assert payloads.decode_topic(payload).buffer_size == 32767


def test_id_that_no_topic_has_is_refused() -> None:
    with pytest.raises(PayloadError, match="99"):
        payloads.decode_topic(payloads.encode_topic(GOOD._replace(topic_id=99)))


def test_the_smallest_and_the_largest_are_taken() -> None:
    for changed in (
        {"topic_id": 100},
        {"topic_id": 65535},
        {"buffer_size": 1},
        {"buffer_size": 32767},
        {"md5sum": "*"},
    ):
        info = GOOD._replace(**changed)
        assert payloads.decode_topic(payloads.encode_topic(info)) == info
        assert payloads.problem_of(info) == ""


def test_invalid_level_and_name_are_rejected() -> None:
    with pytest.raises(PayloadError, match="log"):
        payloads.decode_log(payloads.encode_log(5, "text"))
    with pytest.raises(PayloadError, match="log"):
        payloads.decode_log(b"")
    with pytest.raises(PayloadError, match="invalid parameter name"):
        payloads.decode_name(payloads.encode_name("a b"))


def test_more_numbers_than_there_are_bytes_are_refused_before_they_are_read() -> None:
    with pytest.raises(PayloadError, match="truncated"):
        payloads.decode_values(struct.pack("<I", 0xFFFFFFFF))


def test_the_bytes_are_those_of_the_published_definitions() -> None:
    assert payloads.encode_log(2, "hi") == b"\x02\x02\0\0\0hi"
    assert payloads.encode_topic(TopicInfo(0x0102, "a", "b/C", "*", 512)) == (
        b"\x02\x01\x01\0\0\0a\x03\0\0\0b/C\x01\0\0\0*\0\x02\0\0"
    )
    assert payloads.encode_values(ParameterValues([1], [1.0], ["a"])) == (
        b"\x01\0\0\0\x01\0\0\0\x01\0\0\0\0\0\x80?\x01\0\0\0\x01\0\0\0a"
    )
    assert payloads.encode_time(1, 2) == b"\x01\0\0\0\x02\0\0\0"
    assert payloads.encode_name("a") == b"\x01\0\0\0a"
    assert list(payloads.TOPICS) == [0, 1, 2, 3, 4, 5]


def test_the_ids_are_those_of_the_published_definitions() -> None:
    """Both sides of the tests share these constants: a wrong one would go unnoticed otherwise."""
    p = payloads
    kinds = (p.PUBLISHER, p.SUBSCRIBER, p.SERVICE_SERVER, p.SERVICE_CLIENT)
    assert kinds == (0, 1, 2, 4)
    assert (p.PARAMETER, p.LOG, p.TIME, p.STOP, p.FIRST_TOPIC) == (6, 7, 10, 11, 100)
    assert (p.DEBUG, p.INFO, p.WARN, p.ERROR, p.FATAL) == (0, 1, 2, 3, 4)
