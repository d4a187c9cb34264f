"""Contents of a saved picture."""

from pathlib import Path
from typing import List, Tuple

import numpy
from matplotlib.image import imread

#: Edges on the left, above, on the right and below, pixels of the page: from the far end if
#: negative, and the end itself if 0.
Box = Tuple[float, float, float, float]
#: Colours that differ by less look the same.
_ALIKE = 24
#: Height of a line of text, and the space below the last line, pixels of the page.
_LINE, _MARGIN = 17, 10
#: Longer than any letter, pixels of the page.
_LETTER = 20


class Picture:
    """A picture for a report.

    :param path: the file
    :param ratio: picture pixels per page pixel
    """

    def __init__(self, path: Path, ratio: float) -> None:
        self.pixels = numpy.rint(imread(str(path))[:, :, :3] * 255.0).astype(int)
        self.ratio = ratio
        #: Pixels that differ from the empty first corner.
        self.painted = (abs(self.pixels - self.pixels[0, 0]) >= _ALIKE).any(axis=2)

    def part(self, shown: numpy.ndarray, box: Box) -> numpy.ndarray:
        """Return a part of an array of the size of the picture.

        :param shown: such as :attr:`painted`
        :param box: the part
        """
        left, top, right, bottom = (round(edge * self.ratio) or None for edge in box)
        return shown[top:bottom, left:right]

    def of_colour(self, colour: str) -> numpy.ndarray:
        """Return a mask of the pixels of a colour.

        :param colour: ``#rrggbb``
        """
        wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
        return (abs(self.pixels - wanted) < _ALIKE).all(axis=2)

    def lines(self, top: float) -> List[bool]:
        """Return for each line of text below a place whether it is written.

        :param top: the place, pixels of the page
        """
        end = self.painted.shape[0] / self.ratio - _MARGIN - 1.0
        starts = numpy.arange(top, end, _LINE)
        return [bool(self.part(self.painted, (0, at, 0, at + _LINE)).any()) for at in starts]

    def strokes(self, box: Box, height: float) -> List[str]:
        """Return the edges of a box with a line longer than any letter.

        :param box: the box
        :param height: lower end of the search, pixels of the page
        """
        left, _, right, bottom = box  # there is nothing above a plot
        beside = {
            "left": (0, 0, left, height),
            "right": (right, 0, 0, height),
            "below": (left, bottom, right, height),
        }
        found = {side: self.part(self.painted, place) for side, place in beside.items()}
        longest = _LETTER * self.ratio
        return [side for side, one in found.items() if max(_run(one), _run(one.T)) > longest]


def _run(painted: numpy.ndarray) -> int:
    """Return the longest vertical run of painted pixels."""
    run, most = numpy.zeros(painted.shape[1], int), 0
    for row in painted:
        run = (run + 1) * row
        most = max(most, int(run.max(initial=0)))
    return most
