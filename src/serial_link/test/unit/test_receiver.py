"""Frame receiver of a board."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from serial_link.device.receiver import SYNC_BYTE, TABLE, Receiver
from serial_link.framing.frames import PROBE, Frame, encode

frames = st.builds(Frame, st.integers(0, 0xFFFF), st.binary(max_size=40))


def test_state_table_is_complete() -> None:
    assert TABLE
    for expected in TABLE.values():
        assert expected.if_good in TABLE and expected.if_bad == SYNC_BYTE


@given(st.lists(frames, max_size=5), st.lists(st.integers(0, 300)))
def test_frames_are_received_for_any_split(messages: List[Frame], cuts: List[int]) -> None:
    data = b"".join(encode(*message) for message in messages)
    receiver, found, start = Receiver(40), [], 0
    for cut in [*sorted(cut % (len(data) + 1) for cut in cuts), len(data)]:
        found += receiver.receive(0.0, data[start:cut])
        start = cut
    assert found == messages and receiver.mode == SYNC_BYTE


@given(st.binary(max_size=200))
def test_noise_raises_nothing_and_ends_after_timeout(noise: bytes) -> None:
    receiver, good = Receiver(512), Frame(100, b"good")
    for frame in receiver.receive(0.0, noise):
        assert encode(*frame) in noise
    assert receiver.receive(1.0, encode(*good)) == [good]


@pytest.mark.parametrize("place", [2, 4, 5, 8, -1])
def test_a_damaged_frame_is_dropped(place: int) -> None:
    data = bytearray(encode(100, b"some"))
    data[place] ^= 1
    assert Receiver(512).receive(0.0, bytes(data)) == []


def test_a_frame_that_takes_too_long_is_dropped() -> None:
    data = encode(100, b"some")
    # As rosserial's library, after 20 ms.
    for pause, expected in ((0.019, [Frame(100, b"some")]), (0.021, [])):
        receiver = Receiver(512)
        assert receiver.receive(5.0, data[:6]) == []
        assert receiver.receive(5.0 + pause, data[6:]) == expected


def test_probe_counts_as_other_version() -> None:
    receiver, good = Receiver(512), Frame(100, b"")
    assert receiver.receive(0.0, PROBE + encode(*good)) == [good]
    assert receiver.other_versions == 1


def test_a_message_beyond_the_buffer_is_dropped_and_counted() -> None:
    receiver, good = Receiver(4), Frame(100, b"good")
    assert receiver.receive(0.0, encode(100, b"large")) == [] and receiver.too_long == 1
    assert receiver.receive(1.0, encode(*good)) == [good] and receiver.too_long == 1


def test_damaged_length_is_no_message_beyond_the_buffer() -> None:
    receiver, data = Receiver(4), bytearray(encode(100, b"some"))
    data[2] ^= 0x80
    assert receiver.receive(0.0, bytes(data)) == [] and receiver.too_long == 0
