"""Test card: static content, and moving objects."""

from typing import Tuple

import numpy
import pytest

from parameters_demo.picture import HEIGHT, WIDTH, Picture


def drawn(name: str, number: int, time: float) -> numpy.ndarray:
    data = bytes(Picture(name).draw(number, time))
    return numpy.frombuffer(data, numpy.uint8).reshape(HEIGHT, WIDTH, 3)


def changed(one: numpy.ndarray, other: numpy.ndarray) -> Tuple[int, int, int, int]:
    """Return first and last row, first and last column of the difference."""
    rows, columns = numpy.nonzero((one != other).any(axis=2))
    return rows.min(), rows.max(), columns.min(), columns.max()


def test_the_colours_are_in_their_order() -> None:
    card = drawn("camera", 0, 0.0)  # the ball is at the upper left
    bars = [tuple(card[200, column]) for column in range(40, WIDTH, 80)]
    on, off = 0xC0, 0
    assert bars[1:4] == [(on, on, off), (off, on, on), (off, on, off)]
    assert bars[4:] == [(on, off, on), (on, off, off), (off, off, on), (off, off, off)]
    ramp = card[300].astype(int)
    assert ramp[0, 0] == 0 and ramp[-1, 0] == 255
    assert (numpy.diff(ramp[:, 0]) >= 0).all() and (ramp[:, 0] == ramp[:, 2]).all()


@pytest.mark.parametrize("name", ["", "front_camera", "a name that is far too long for a picture"])
def test_name_is_above_number_and_time(name: str) -> None:
    top, bottom, left, _ = changed(drawn(name, 0, 0.0), drawn("x", 0, 0.0))
    assert 320 < top and bottom < 390 and left >= 24


def test_letters_that_the_font_lacks_become_question_marks() -> None:
    assert (drawn("\u673a", 0, 0.0) == drawn("?", 0, 0.0)).all()
    assert (drawn("?", 0, 0.0) != drawn("x", 0, 0.0)).any()


def test_number_and_time_have_separate_lines() -> None:
    top, bottom, left, right = changed(drawn("camera", 1, 0.0), drawn("camera", 2, 0.0))
    assert 390 < top and bottom < 430 and right < 480
    times = drawn("camera", 1, 0.0)[430:460, :480], drawn("camera", 1, 0.001)[430:460, :480]
    top, bottom, left, right = changed(*times)
    assert right - left < 20  # a digit


def test_the_hand_points_up_at_a_full_second_and_down_half_a_second_later() -> None:
    for time, row in ((7.0, 370), (7.5, 430)):
        card = drawn("camera", 0, time)
        assert tuple(card[row, 560]) == (255, 255, 255)
        assert tuple(card[800 - row, 560]) == (0, 0, 0)


def ball(picture: Picture, time: float) -> Tuple[int, int]:
    """Return the position of the ball; check that it is complete."""
    data = numpy.frombuffer(picture.draw(0, time), numpy.uint8).reshape(HEIGHT, WIDTH, 3)
    red, green, blue = data[:280, :, 0], data[:280, :, 1], data[:280, :, 2]
    white = (red & green & blue) == 255
    assert white.sum() == 1793  # pixels of a disc with radius 24
    rows, columns = numpy.nonzero(white)
    return int(rows.min()), int(columns.min())


def test_ball_moves_smoothly_within_the_bars() -> None:
    picture = Picture("camera")
    places = [ball(picture, frame / 60.0) for frame in range(360)]
    assert len(set(places)) > 300
    for (row, column), (next_row, next_column) in zip(places, places[1:]):
        assert abs(next_row - row) <= 4 and abs(next_column - column) <= 4
    rows, columns = zip(*places)
    assert min(rows) <= 2 and max(rows) >= 228 and min(columns) <= 2 and max(columns) >= 588


def test_any_time_and_number_can_be_drawn() -> None:
    picture = Picture("camera")
    for number, time in ((0, 0.0), (10**30, 1795322737.999), (1, 1e12), (-1, -3.5)):
        assert len(picture.draw(number, time)) == 3 * WIDTH * HEIGHT


def test_previous_drawing_is_erased() -> None:
    picture = Picture("camera")
    first = bytes(picture.draw(1, 1.0))
    assert bytes(picture.draw(99999, 2.3)) != first
    assert bytes(picture.draw(1, 1.0)) == first
