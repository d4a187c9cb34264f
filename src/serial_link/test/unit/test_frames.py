"""Frames as the wire has them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from serial_link.framing.frames import (
    LONGEST,
    OLD_REQUEST,
    OVERHEAD,
    PROBE,
    count_old_frames,
    encode,
)


def test_the_bytes_are_those_of_the_published_protocol() -> None:
    assert encode(0, b"") == b"\xff\xfe\x00\x00\xff\x00\x00\xff"
    assert encode(11, b"") == b"\xff\xfe\x00\x00\xff\x0b\x00\xf4"
    assert encode(0x0102, b"\x10\xff") == b"\xff\xfe\x02\x00\xfd\x02\x01\x10\xff\xed"


@given(st.integers(0, 0xFFFF), st.binary(max_size=600))
def test_both_sums_are_255(topic_id: int, payload: bytes) -> None:
    data = encode(topic_id, payload)
    assert len(data) == len(payload) + OVERHEAD
    assert sum(data[2:5]) % 256 == sum(data[5:]) % 256 == 255


def test_too_long_payload_is_rejected() -> None:
    assert len(encode(0, bytes(LONGEST))) == LONGEST + OVERHEAD
    with pytest.raises(ValueError, match="32768 bytes: at most 32767"):
        encode(0, bytes(LONGEST + 1))


def old_frame(topic_id: int, payload: bytes) -> bytes:
    body = topic_id.to_bytes(2, "little") + len(payload).to_bytes(2, "little") + payload
    return PROBE + body + bytes([255 - sum(body) % 256])


def test_old_protocol_frames_are_distinguished() -> None:
    assert old_frame(0, b"") == OLD_REQUEST[:-1]
    old = old_frame(125, b"some") + b"noise" + old_frame(0, b"")
    assert count_old_frames(b"\xff\xff\x01" + old) == 2
    assert count_old_frames(old[:-1]) == 1
    assert count_old_frames(encode(0, b"") + encode(125, b"some")) == 0
    assert count_old_frames(b"\xff\xff" + old) == 2  # found behind a false beginning
    for size, count in ((512, 1), (513, 0)):
        assert count_old_frames(old_frame(0, bytes(size))) == count
    assert count_old_frames(old_frame(300, b"a")[:-1] + b"\0") == 0
    assert count_old_frames(PROBE) == count_old_frames(PROBE + bytes(3)) == 0
