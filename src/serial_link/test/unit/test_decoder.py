"""Frames are found in whatever arrives."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from serial_link.framing.decoder import (
    CHECKSUM,
    CUT_OFF,
    GARBAGE,
    LENGTH,
    LENGTH_CHECKSUM,
    NOISY_FRAMES,
    Decoder,
)
from serial_link.framing.frames import LONGEST, START, Frame, encode

frames = st.builds(Frame, st.integers(0, 0xFFFF), st.binary(max_size=80))
#: Messages that do not contain anything like the beginning of another frame.
plain = st.lists(
    st.builds(
        Frame, st.integers(0, 0xFE), st.binary(max_size=40).map(lambda b: b.replace(b"\xff", b"."))
    ),
    min_size=3,
    max_size=6,
)


def wire(messages: List[Frame]) -> bytes:
    return b"".join(encode(*message) for message in messages)


def fed_in_pieces(data: bytes, cuts: List[int]) -> "tuple[List[Frame], Decoder]":
    decoder, found, start = Decoder(), [], 0
    for cut in [*sorted(cut % (len(data) + 1) for cut in cuts), len(data)]:
        found += decoder.feed(data[start:cut])
        start = cut
    return found + decoder.flush(), decoder


@given(st.lists(frames, max_size=5), st.lists(st.integers(0, 10_000)))
def test_frames_are_decoded_for_any_split(messages: List[Frame], cuts: List[int]) -> None:
    found, decoder = fed_in_pieces(wire(messages), cuts)
    assert found == messages
    assert not +decoder.faults


@given(st.binary(max_size=300), st.lists(st.integers(0, 10_000)))
def test_noise_raises_nothing_and_split_is_irrelevant(noise: bytes, cuts: List[int]) -> None:
    whole, at_once = fed_in_pieces(noise, [])
    pieces, cut = fed_in_pieces(noise, cuts)
    assert whole == pieces
    assert +at_once.faults == +cut.faults
    carried = sum(len(encode(*frame)) for frame in whole)
    assert carried + at_once.faults[GARBAGE] == len(noise)


@given(
    plain,
    st.lists(
        st.tuples(st.integers(0, 10_000), st.integers(0, 255), st.sampled_from("=+-")), max_size=8
    ),
    st.lists(st.integers(0, 10_000)),
)
def test_damage_raises_nothing_and_only_valid_checksums_pass(
    messages: List[Frame], damage: List["tuple[int, int, str]"], cuts: List[int]
) -> None:
    data = bytearray(wire(messages))
    for place, value, how in damage:
        place %= len(data)
        if how == "=":
            data[place] = value
        elif how == "+":
            data.insert(place, value)
        else:
            del data[place]
    found, _ = fed_in_pieces(bytes(data), cuts)
    for frame in found:  # it stands there with its sums, byte by byte
        assert encode(*frame) in data


@given(st.binary(max_size=60), plain, st.lists(st.integers(0, 10_000)))
def test_two_good_messages_after_any_damage_it_is_in_step_again(
    damage: bytes, messages: List[Frame], cuts: List[int]
) -> None:
    data = damage + wire(messages) + START[:1]  # of the next frame
    decoder, found, start = Decoder(), [], 0
    for cut in [*sorted(cut % (len(data) + 1) for cut in cuts), len(data)]:
        found += decoder.feed(data[start:cut])
        start = cut
    # Without waiting for silence: a wrong length must not delay the following frames for long.
    assert found[len(found) - len(messages[2:]) :] == messages[2:]


@pytest.mark.parametrize("size", [1, 200, 512, LONGEST])
def test_wrong_length_delays_two_messages_and_loses_none(size: int) -> None:
    lie = encode(125, bytes(size))[:7]
    messages = [Frame(125, b"one"), Frame(126, b"two"), Frame(125, b"three")]
    decoder = Decoder()
    assert decoder.feed(lie + wire(messages[:1])) == ([] if size > 1 else messages[:1])
    assert decoder.feed(wire(messages[1:])) == messages[size == 1 :]
    assert sum(decoder.faults[kind] for kind in (LENGTH, CHECKSUM)) == 1


@pytest.mark.parametrize(
    "place, fault",
    [(2, LENGTH_CHECKSUM), (4, LENGTH_CHECKSUM), (5, CHECKSUM), (8, CHECKSUM), (-1, CHECKSUM)],
)
def test_faults_are_counted_by_type(place: int, fault: str) -> None:
    data = bytearray(encode(125, b"some"))
    data[place] ^= 0x10
    decoder = Decoder()
    good = Frame(126, b"good")
    assert decoder.feed(bytes(data) + encode(*good)) == [good]
    assert +decoder.faults == {fault: 1, GARBAGE: len(data)}


@pytest.mark.parametrize("place", [8, 9, 10])
def test_next_frame_does_not_make_up_for_a_lost_byte(place: int) -> None:
    decoder, good = noisy_decoder(), Frame(126, b"good")
    data = bytearray(encode(125, b"\xfb\xff\xff\xff"))
    del data[place]
    assert decoder.feed(bytes(data) + encode(*good)) == [good]
    assert decoder.feed(bytes(data)) + decoder.feed(START[:1]) == []
    assert decoder.feed(encode(*good)[1:]) == [good]
    assert decoder.faults[CHECKSUM] == 3


def test_line_that_loses_only_sync_bytes_is_noisy_after_the_first_one() -> None:
    decoder, good = Decoder(), Frame(126, b"good")
    data = bytearray(encode(125, b"\xfb\xff\xff\xff"))
    del data[10]
    completed = Frame(125, b"\xfb\xff\xff" + data[-1:])
    assert decoder.feed(bytes(data) + encode(*good)) == [completed]
    assert decoder.feed(bytes(data) + encode(*good)) == [good]
    assert +decoder.faults == {GARBAGE: len(encode(*good)) - 1 + len(data), CHECKSUM: 1}


def test_frame_that_ends_with_sync_byte_waits_only_on_a_noisy_line() -> None:
    last = Frame(0, b"")
    assert encode(*last)[-1:] == START[:1]
    assert Decoder().feed(encode(*last)) == [last]
    decoder = noisy_decoder()
    assert decoder.feed(encode(*last)) == []
    assert decoder.feed(encode(*last)) == [last]  # the first one
    assert decoder.flush() == [last]
    other = Frame(125, b"other")
    assert decoder.feed(wire([other] * NOISY_FRAMES)) == [other] * NOISY_FRAMES
    assert decoder.feed(encode(*last)) == [last]


def noisy_decoder() -> Decoder:
    """Return a decoder that has received a damaged frame."""
    decoder = Decoder()
    assert decoder.feed(encode(125, b"some")[:-1] + b"\0") == []
    assert decoder.faults[CHECKSUM] == 1
    return decoder


def test_a_length_beyond_all_messages_is_not_waited_for() -> None:
    decoder, good = Decoder(longest=20), Frame(126, bytes(20))
    assert decoder.feed(encode(125, bytes(21))[:7] + encode(*good)) == [good]
    assert decoder.faults[LENGTH] == 1


def test_incomplete_frame_is_dropped_and_hidden_frames_decoded() -> None:
    decoder, good = Decoder(), Frame(126, b"good")
    assert decoder.feed(encode(125, bytes(100))[:7]) == decoder.feed(encode(*good)) == []
    assert decoder.is_waiting
    assert decoder.flush() == [good]
    assert not decoder.is_waiting
    assert decoder.faults[CUT_OFF] == 1
    assert decoder.feed(START) == [] and decoder.is_waiting
    decoder.reset()
    assert not decoder.is_waiting
    decoder, cut = Decoder(), encode(125, b"some")[:-1]
    assert decoder.feed(cut) + decoder.flush() == []
    assert +decoder.faults == {CUT_OFF: 1, GARBAGE: len(cut)}


@pytest.mark.parametrize("payload", [b"", b"a", bytes(300)])
def test_the_second_message_within_a_lying_length_gives_it_away(payload: bytes) -> None:
    decoder, messages = Decoder(), [Frame(125, payload), Frame(126, payload)]
    assert decoder.feed(encode(125, bytes(LONGEST))[:7] + encode(*messages[0])) == []
    assert decoder.feed(encode(*messages[1])[:-1]) == []
    assert decoder.feed(encode(*messages[1])[-1:]) == messages
    assert decoder.faults[LENGTH] == 1
    decoder, lie = Decoder(), encode(125, bytes(LONGEST))[:7] + START + b"x"
    assert decoder.feed(lie + wire(messages)) == messages  # behind a false beginning


def test_a_stray_sync_byte_costs_no_message() -> None:
    decoder, good = Decoder(), Frame(125, b"good")
    assert decoder.feed(START[:1] + encode(*good)) == [good]
    assert +decoder.faults == {GARBAGE: 1}


@given(frames, st.lists(frames, max_size=3))
def test_whole_frame_is_validated_like_one_in_pieces(message: Frame, inner: List[Frame]) -> None:
    """A frame may contain others, by chance or because its length is wrong."""
    data = encode(message.topic_id, message.payload + wire(inner))
    at_once, in_pieces = Decoder(), Decoder()
    found = at_once.feed(data) + at_once.flush()
    pieces = [in_pieces.feed(data[:1]), in_pieces.feed(data[1:]), in_pieces.flush()]
    assert found == sum(pieces, []) and +at_once.faults == +in_pieces.faults


def test_damaged_frame_that_arrives_whole_is_rejected() -> None:
    good = encode(125, b"1234")
    for place in range(len(good)):
        damaged = bytearray(good)
        damaged[place] ^= 1
        decoder = Decoder()
        assert decoder.feed(bytes(damaged)) + decoder.flush() == []
    decoder = Decoder(longest=3)
    assert decoder.feed(good) == [] and decoder.faults[LENGTH] == 1
