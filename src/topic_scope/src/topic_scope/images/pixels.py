# Pure: knows no ROS.
"""Pixels of a sensor_msgs/Image, converted to 8 bits per channel.

The encodings are those of http://docs.ros.org/en/noetic/api/sensor_msgs/html/image__encodings_8h.html.
"""

import re
from typing import Any, List, Mapping, NamedTuple, Tuple

import numpy

#: Longest side of a converted image [pixels]; larger images are subsampled.
LONGEST_SIDE = 1024
#: Encodings with named channels: their indices in the order red, green, blue, alpha.
_COLOURS = {"mono": (0,), "rgb": (0, 1, 2), "bgr": (2, 1, 0), "rgba": (0, 1, 2, 3)}
_COLOURS["bgra"] = (2, 1, 0, 3)
#: Encoding as which unnamed channels are shown, by their number.
_UNNAMED = {1: "mono", 3: "bgr", 4: "bgra"}
_KINDS = {"U": "u", "S": "i", "F": "f"}
_NAMED = re.compile(r"(mono|rgba?|bgra?)(8|16)\Z")
_BAYER = re.compile(r"bayer_(rggb|bggr|gbrg|grbg)(8|16)\Z")
_PLAIN = re.compile(r"(8|16|32|64)([USF])C([134])?\Z")
_SHOWN = (
    "supported are mono, rgb, bgr, rgba, bgra and bayer_ with 8 or 16 bits, 8UC1, 8UC3, 8UC4, and "
    "numbers with one channel such as 16UC1 and 32FC1"
)


class ImageProblem(ValueError):
    """Image that cannot be shown; the text states the reason."""


class ConvertedImage(NamedTuple):
    """Pixels for a browser.

    :param pixels: uint8, of shape (height, width, channels), with 1, 3 or 4 channels
    :param notes: texts about the conversion
    """

    pixels: numpy.ndarray
    notes: List[str]


class _Encoding(NamedTuple):
    """Encoding of an image.

    :param number: type of the numbers
    :param channels: number of channels in the message
    :param order: channels in the order red, green, blue, alpha
    :param bayer: colours of a block of 2 x 2 pixels by rows; empty for other encodings
    :param scaled: whether the range of the numbers is scaled to black to white
    :param notes: texts about the interpretation
    """

    number: numpy.dtype
    channels: int
    order: Tuple[int, ...]
    bayer: str = ""
    scaled: bool = False
    notes: Tuple[str, ...] = ()


def convert(image: Mapping[str, Any]) -> ConvertedImage:
    """Return the pixels of a message.

    :param image: fields of a sensor_msgs/Image; ``data`` as a numeric array
    :raises ImageProblem: if the encoding is not supported, or the data do not match the size
    """
    encoding = _encoding_of(image["encoding"])
    pixels = _rows_of(image, encoding)
    notes = list(encoding.notes)
    if encoding.scaled:
        low, high, missing = _range_of(pixels)
        notes.append(f"black {low:.6g} to white {high:.6g}")
        if missing:
            notes.append(f"{missing} pixels are not finite: black")
        return _thinned(pixels, lambda some: _scaled(some, low, high), notes)
    if encoding.bayer:
        notes.append("demosaiced at half of the resolution")
        blocks = _blocks(pixels[:, :, 0])
        return _thinned(blocks, lambda some: _demosaiced(some, encoding.bayer), notes)
    return _thinned(pixels[:, :, list(encoding.order)], _eight_bits, notes)


def _encoding_of(name: str) -> _Encoding:
    match = _NAMED.match(name)
    if match:
        order = _COLOURS[match.group(1)]
        scaled = name == "mono16"
        notes = () if match.group(2) == "8" or scaled else ("upper 8 of 16 bits",)
        return _Encoding(_number("u", match.group(2)), len(order), order, "", scaled, notes)
    match = _BAYER.match(name)
    if match:
        notes = () if match.group(2) == "8" else ("upper 8 of 16 bits",)
        return _Encoding(_number("u", match.group(2)), 1, (0,), match.group(1), False, notes)
    match = _PLAIN.match(name)
    if match:
        bits, kind, channels = match.group(1), match.group(2), int(match.group(3) or 1)
        shown = _UNNAMED[channels]
        if (bits, kind) == ("8", "U"):
            notes = () if channels == 1 else (f"channels interpreted as {shown}8",)
            return _Encoding(_number("u", "8"), channels, _COLOURS[shown], "", False, notes)
        if channels == 1 and (bits, kind) not in (("8", "F"), ("16", "F")):
            return _Encoding(_number(_KINDS[kind], bits), 1, (0,), "", True)
    raise ImageProblem(f"unsupported encoding {name[:40]!r}; {_SHOWN}")


def _number(kind: str, bits: str) -> numpy.dtype:
    return numpy.dtype(f"<{kind}{int(bits) // 8}")


def _rows_of(image: Mapping[str, Any], encoding: _Encoding) -> numpy.ndarray:
    """Return the numbers of a message, of shape (height, width, channels), without copying."""
    height, width, step = (int(image[name]) for name in ("height", "width", "step"))
    data: numpy.ndarray = image["data"]
    if not height or not width:
        raise ImageProblem(f"the image is empty: {width} × {height} pixels")
    used = width * encoding.channels * encoding.number.itemsize
    if step < used:
        raise ImageProblem(f"a row of {width} pixels takes {used} bytes, but step is {step}")
    needed = step * (height - 1) + used
    if len(data) < needed:
        raise ImageProblem(f"the image takes {needed} bytes, but the message has {len(data)}")
    number = encoding.number.newbyteorder(">") if image["is_bigendian"] else encoding.number
    shape = (height, width, encoding.channels)
    strides = (step, encoding.channels * number.itemsize, number.itemsize)
    return numpy.ndarray(shape, number, numpy.ascontiguousarray(data).data, 0, strides)


def _range_of(pixels: numpy.ndarray) -> Tuple[float, float, int]:
    """Return the smallest and the largest finite number, and how many are not finite."""
    if pixels.dtype.kind != "f":
        return float(pixels.min()), float(pixels.max()), 0
    finite = numpy.isfinite(pixels)
    missing = int(pixels.size - finite.sum())
    if missing == pixels.size:
        raise ImageProblem("no pixel is a finite number")
    least = pixels.min(initial=numpy.inf, where=finite)
    return float(least), float(pixels.max(initial=-numpy.inf, where=finite)), missing


def _scaled(pixels: numpy.ndarray, low: float, high: float) -> numpy.ndarray:
    """Return numbers from low to high scaled to 0 to 255; 0 for those that are not finite."""
    numbers = pixels.astype(numpy.float64)
    # Halved, so that the difference of large numbers is not infinite.
    span = high / 2.0 - low / 2.0
    parts = (numbers / 2.0 - low / 2.0) / span if span > 0.0 else numpy.zeros_like(numbers)
    parts[~numpy.isfinite(parts)] = 0.0
    return numpy.rint(parts * 255.0).astype(numpy.uint8)


def _eight_bits(pixels: numpy.ndarray) -> numpy.ndarray:
    return (pixels >> 8 if pixels.dtype.itemsize == 2 else pixels).astype(numpy.uint8)


def _blocks(pixels: numpy.ndarray) -> numpy.ndarray:
    """Return the four pixels of each 2 x 2 block, without an odd last row or column."""
    height, width = (side // 2 * 2 for side in pixels.shape)
    if not height or not width:
        raise ImageProblem("a Bayer pattern needs at least 2 × 2 pixels")
    even = pixels[:height, :width]
    corners = [even[row::2, column::2] for row in (0, 1) for column in (0, 1)]
    return numpy.stack(corners, axis=2)


def _demosaiced(blocks: numpy.ndarray, bayer: str) -> numpy.ndarray:
    """Return one pixel for each block: its red, the mean of its greens, its blue."""
    eight = _eight_bits(blocks)
    first, second = (place for place, colour in enumerate(bayer) if colour == "g")
    green = (eight[:, :, first].astype(numpy.uint16) + eight[:, :, second]) // 2
    red, blue = eight[:, :, bayer.index("r")], eight[:, :, bayer.index("b")]
    return numpy.stack([red, green.astype(numpy.uint8), blue], axis=2)


def _thinned(pixels: numpy.ndarray, finish: Any, notes: List[str]) -> ConvertedImage:
    """Convert an image, reduced to every n-th pixel if it is large."""
    every = -(-max(pixels.shape[:2]) // LONGEST_SIDE)
    if every > 1:
        notes = [*notes, f"subsampled by {every}"]
    return ConvertedImage(finish(pixels[::every, ::every]), notes)
