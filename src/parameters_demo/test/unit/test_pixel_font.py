"""Letters of pixels."""

import numpy

from parameters_demo.pixel_font import ADVANCE, HEIGHT, text


def test_a_letter_is_what_its_drawing_shows() -> None:
    rows = ["".join("#" if dot else "." for dot in row) for row in text("L", 1)]
    assert rows == ["#....."] * 6 + ["#####."]


def test_letters_stand_side_by_side_and_grow_with_the_scale() -> None:
    for scale in (1, 2, 5):
        line = text("a7", scale)
        assert line.shape == (HEIGHT * scale, 2 * ADVANCE * scale)
        assert (line[:, : ADVANCE * scale] == text("A", scale)).all()
        assert (line[::scale, ::scale] == text("A7", 1)).all()
        assert set(numpy.unique(line)) == {0, 255}


def test_all_letters_differ_and_a_box_stands_for_the_rest() -> None:
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.:/ é"
    assert len({text(letter, 1).tobytes() for letter in letters}) == len(letters)
    assert (text("é", 1) == text("你", 1)).all()
    assert text("ß", 1).shape == text("A", 1).shape  # of which two capitals are made
