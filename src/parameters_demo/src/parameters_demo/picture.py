# Pure: knows no ROS.
"""Picture of the simulated camera: a test card with a moving object.

Colour bars and a grey ramp show whether the colours are right, the name identifies the camera, the
frame number shows lost frames, the time their age, and the dial and the ball smooth motion.
"""

import math

import numpy
from PIL import ImageFont

#: Size [pixels].
WIDTH, HEIGHT = 640, 480

_BARS = (0xC0C0C0, 0xC0C000, 0x00C0C0, 0x00C000, 0xC000C0, 0xC00000, 0x0000C0, 0x000000)
_BARS_END, _RAMP_END = 280, 320  # rows
_RING = 0x60
_LEFT = 24  # first column of texts
_NAME_ROW, _NUMBER_ROW, _TIME_ROW = 338, 396, 434
_MOST_LETTERS = 19  # of a name: the dial is beside it
_DIAL_X, _DIAL_Y, _DIAL_RADIUS = 560, 400, 64
_BALL_RADIUS = 24
#: Periods of the ball's horizontal and vertical motion, one way [s].
_ACROSS_S, _DOWN_S = 3.1, 1.7


class Picture:
    """A test card.

    :param name: shown on it; a long name is truncated
    """

    def __init__(self, name: str) -> None:
        # A buffer that the message uses directly, without a copy.
        self._data = bytearray(3 * WIDTH * HEIGHT)
        self._pixels = numpy.frombuffer(self._data, numpy.uint8).reshape(HEIGHT, WIDTH, 3)
        self._card = _card(name)
        self._hand = numpy.arange(_DIAL_RADIUS - 6)
        squares = numpy.arange(-_BALL_RADIUS, _BALL_RADIUS + 1) ** 2
        self._ball = squares[:, None] + squares <= _BALL_RADIUS**2

    def draw(self, number: int, time: float) -> bytearray:
        """Return the picture at a time.

        :param number: of the frame
        :param time: the time [s]
        :returns: rgb8, row by row; the same buffer each time
        """
        self._pixels[:] = self._card
        _write(self._pixels, _NUMBER_ROW, f"FRAME {number}", 3)
        _write(self._pixels, _TIME_ROW, f"TIME {time:.3f}", 3)
        self._turn_hand(math.tau * (time % 1.0))
        self._throw_ball(time)
        return self._data

    def _turn_hand(self, angle: float) -> None:
        rows = (_DIAL_Y - self._hand * math.cos(angle)).astype(int)
        columns = (_DIAL_X + self._hand * math.sin(angle)).astype(int)
        for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
            self._pixels[rows + row, columns + column] = 255

    def _throw_ball(self, time: float) -> None:
        column = int(_there_and_back(time / _ACROSS_S) * (WIDTH - self._ball.shape[1]))
        row = int(_there_and_back(time / _DOWN_S) * (_BARS_END - self._ball.shape[0]))
        height, width = self._ball.shape
        self._pixels[row : row + height, column : column + width][self._ball] = 255


def _there_and_back(turns: float) -> float:
    """Return a triangle wave: 0 to 1 in one turn, and back in the next."""
    return 1.0 - abs(1.0 - turns % 2.0)


def _card(name: str) -> numpy.ndarray:
    """Return the static part of the picture."""
    card = numpy.zeros((HEIGHT, WIDTH, 3), numpy.uint8)
    for number, colour in enumerate(_BARS):
        bar = slice(number * WIDTH // len(_BARS), (number + 1) * WIDTH // len(_BARS))
        card[:_BARS_END, bar] = [colour >> 16, colour >> 8 & 0xFF, colour & 0xFF]
    card[_BARS_END:_RAMP_END] = numpy.linspace(0, 255, WIDTH).astype(numpy.uint8)[None, :, None]
    rows, columns = numpy.ogrid[:HEIGHT, :WIDTH]
    distance = numpy.hypot(rows - _DIAL_Y, columns - _DIAL_X)
    card[abs(distance - _DIAL_RADIUS) < 2] = _RING
    _write(card, _NAME_ROW, name[:_MOST_LETTERS] or " ", 4)
    return card


def _write(pixels: numpy.ndarray, row: int, line: str, scale: int) -> None:
    letters = _letters(line, scale)[:, : pixels.shape[1] - _LEFT]
    height, width = letters.shape
    pixels[row : row + height, _LEFT : _LEFT + width] = letters[..., None]


def _letters(line: str, scale: int) -> numpy.ndarray:
    """Return a line of text as rows of pixels, 255 for ink and 0 for paper.

    :param line: at least one character; "?" replaces those outside Latin-1, which the font lacks
    :param scale: pixels of the picture per pixel of the font
    """
    known = line.upper().encode("latin-1", "replace").decode("latin-1")
    mask = ImageFont.load_default().getmask(known, mode="1")
    width, height = mask.size
    pixels = numpy.array(mask, numpy.uint8).reshape(height, width)
    return numpy.kron(pixels, numpy.ones((scale, scale), numpy.uint8))
