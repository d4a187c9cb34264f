"""Diagnosis of a board that does not answer."""

import pytest

from serial_link.framing.frames import PROBE, encode
from serial_link.host.connect_diagnosis import MOST_KEPT, ConnectDiagnosis

OLD = PROBE + b"\x7d\x00\x01\x00x" + bytes([255 - (0x7D + 1 + ord("x"))])


def test_silence_garbage_and_old_protocol_are_distinguished() -> None:
    words = ConnectDiagnosis()
    assert words.explain(9600).startswith("the board sends nothing") and "9600" in words.explain(
        9600
    )
    assert "for this port" in words.explain(0)
    words.add(b"\x00\x80garbled" + OLD, False)
    assert words.explain(9600).startswith("the received bytes are not rosserial messages")
    assert "9600 baud," in words.explain(9600) and "use rosserial," in words.explain(0)
    words.add(OLD, False)
    assert "before ROS Hydro (version byte 0xff" in words.explain(9600)
    words.clear()
    assert words.explain(9600).startswith("the board sends nothing")


def test_bytes_after_good_frame_are_not_kept() -> None:
    words = ConnectDiagnosis()
    words.add(encode(10, b""), True)
    words.add(OLD + OLD, False)
    assert words.explain(9600).startswith("the board sends nothing")
    words.clear()  # the next board
    words.add(OLD + OLD, False)
    assert "before ROS Hydro" in words.explain(9600)


def test_partial_frame_before_first_good_one_is_dropped() -> None:
    words = ConnectDiagnosis()
    words.add(b"\x80rest of a frame", False)
    words.add(encode(10, b""), True)
    assert words.explain(9600).startswith("the board sends nothing")


def test_only_the_latest_words_are_kept() -> None:
    words = ConnectDiagnosis()
    words.add(OLD + OLD, False)
    words.add(bytes(MOST_KEPT), False)
    assert words.explain(9600).startswith("the received bytes are not rosserial messages")


#: Usual baud rates of boards and adapters.
RATES = """
2400 4800 9600 14400 19200 28800 38400 57600 74880 76800 115200 230400 250000 256000 460800 500000
576000 921600 1000000 1152000 1500000 2000000 2500000 3000000 3500000 4000000
""".split()


@pytest.mark.parametrize("rate", map(int, RATES))
def test_usual_baud_rate_is_not_taken_for_a_mistyped_one(rate: int) -> None:
    assert "usual" not in ConnectDiagnosis().explain(rate)
    assert f"({rate} is usual)" in ConnectDiagnosis().explain(rate - rate // 100)


@pytest.mark.parametrize(
    "baud, usual", [(56700, "57600"), (11520, ""), (119200, "115200"), (2400, ""), (500000, "")]
)
def test_mistyped_baud_rate_is_named_with_the_usual_one(baud: int, usual: str) -> None:
    words = ConnectDiagnosis()
    silent = words.explain(baud)
    words.add(b"\x00\x80garbled", False)
    for text in (silent, words.explain(baud)):
        assert f"{baud} baud" in text
        assert (f"{usual} is usual" in text) if usual else "usual" not in text
