"""The messages by which the link to a board is measured."""

from serial_link.framing.frames import encode

from ci.benchmark.plain_board import FRAME, VALUE, number_of, numbered


def test_a_message_tells_whether_it_is_whole() -> None:
    for number in (0, 1, 2**32 - 1):
        message = numbered(number)
        assert number_of(message) == number
        for place in range(len(message)):
            wrong = bytearray(message)
            wrong[place] ^= 1
            assert number_of(bytes(wrong)) is None


def test_its_frame_is_as_long_as_the_line_is_reckoned_with() -> None:
    assert len(encode(125, numbered(7))) == FRAME == VALUE.size + 8
