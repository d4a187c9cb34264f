"""Conversion of images: each encoding against values that are known for each pixel."""

import struct
import zlib
from typing import Any, Dict, List

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topic_scope.images import pixels
from topic_scope.images.pixels import ImageProblem, convert
from topic_scope.images.png import to_png

SIDES = st.integers(1, 9)


def message(
    encoding: str, numbers: numpy.ndarray, padding: int = 0, big: bool = False
) -> Dict[str, Any]:
    """Return the fields of a message.

    :param numbers: of shape (height, width, channels)
    :param padding: bytes at the end of each row
    :param big: whether the numbers are big-endian
    """
    ordered = numbers.astype(numbers.dtype.newbyteorder(">" if big else "<"))
    rows = [row.tobytes() + b"\xaa" * padding for row in ordered]
    return {
        **{"height": len(numbers), "width": numbers.shape[1], "step": len(rows[0])},
        **{"encoding": encoding, "is_bigendian": int(big)},
        "data": numpy.frombuffer(b"".join(rows), numpy.uint8),
    }


def decoded(file: bytes) -> numpy.ndarray:
    """Return the pixels of a PNG file with 8 bits per channel, decoded here row by row."""
    assert file.startswith(b"\x89PNG\r\n\x1a\n")
    parts: Dict[bytes, bytes] = {}
    place = 8
    while place < len(file):
        length, kind = struct.unpack_from(">I4s", file, place)
        body = file[place + 8 : place + 8 + length]
        assert struct.unpack_from(">I", file, place + 8 + length)[0] == zlib.crc32(kind + body)
        parts[kind] = body
        place += 12 + length
    assert list(parts) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, bits, colours, *rest = struct.unpack(">IIBBBBB", parts[b"IHDR"])
    channels = {0: 1, 2: 3, 6: 4}[colours]
    assert (bits, rest) == (8, [0, 0, 0])
    data = zlib.decompress(parts[b"IDAT"])
    rows: List[List[int]] = []
    for row in range(height):
        begin = row * (1 + width * channels)
        assert data[begin] in (0, 1)  # no filter, or the difference from the pixel on the left
        line: List[int] = []
        for index, value in enumerate(data[begin + 1 : begin + 1 + width * channels]):
            left = line[index - channels] if data[begin] and index >= channels else 0
            line.append((value + left) % 256)
        rows.append(line)
    return numpy.array(rows, numpy.uint8).reshape(height, width, channels)


@st.composite
def bytes_of_image(draw: st.DrawFn, channels: int) -> numpy.ndarray:
    height, width = draw(SIDES), draw(SIDES)
    data = draw(st.binary(min_size=height * width * channels, max_size=height * width * channels))
    return numpy.frombuffer(data, numpy.uint8).reshape(height, width, channels)


@given(st.sampled_from([1, 3, 4]).flatmap(bytes_of_image))
def test_png_file_has_the_pixels(image: numpy.ndarray) -> None:
    assert (decoded(to_png(image)) == image).all()


@given(
    st.sampled_from(["mono8", "8UC1", "rgb8", "bgr8", "8UC3", "rgba8", "bgra8", "8UC4"]),
    st.data(),
    st.integers(0, 3),
)
def test_colours_of_eight_bits_are_in_order(encoding: str, data: st.DataObject, pad: int) -> None:
    channels = 1 if encoding[-1] == "1" or "mono" in encoding else 4 if "a" in encoding else 3
    channels = 4 if encoding == "8UC4" else channels
    image = data.draw(bytes_of_image(channels))
    made = convert(message(encoding, image, pad))
    order = list(range(channels))
    if encoding.startswith("bgr") or (encoding[:3] == "8UC" and channels > 1):
        order[:3] = [2, 1, 0]
    assert (made.pixels == image[:, :, order]).all()
    taken = [f"channels interpreted as {'bgra8' if channels == 4 else 'bgr8'}"]
    assert made.notes == (taken if encoding[:3] == "8UC" and channels > 1 else [])


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(
    "encoding, number",
    [("mono16", "u2"), ("16UC1", "u2"), ("16SC1", "i2"), ("32SC1", "i4"), ("8SC1", "i1")]
    + [("32FC1", "f4"), ("64FC1", "f8"), ("32FC", "f4")],
)
def test_numbers_are_scaled_from_least_to_largest(encoding: str, number: str, big: bool) -> None:
    image = numpy.array([[[10], [20]], [[60], [110]]], number)
    made = convert(message(encoding, image, 0, big))
    assert made.pixels[:, :, 0].tolist() == [[0, 26], [128, 255]]
    assert made.notes == ["black 10 to white 110"]


def test_numbers_that_are_not_finite_are_black_and_counted() -> None:
    image = numpy.array([[[numpy.nan], [2.0], [numpy.inf], [-3.0]]], numpy.float32)
    with numpy.errstate(invalid="raise"):  # as their conversion to an integer is undefined
        made = convert(message("32FC1", image))
    assert made.pixels[0, :, 0].tolist() == [0, 255, 0, 0]
    assert made.notes == ["black -3 to white 2", "2 pixels are not finite: black"]


@given(st.lists(st.floats(), min_size=1, max_size=20))
def test_any_numbers_keep_their_order(values: List[float]) -> None:
    image = numpy.array(values).reshape(1, -1, 1)
    finite = [value for value in values if numpy.isfinite(value)]
    if not finite:
        with pytest.raises(ImageProblem, match="no pixel is a finite number"):
            convert(message("64FC1", image))
        return
    shown = convert(message("64FC1", image)).pixels[0, :, 0].tolist()
    pairs = sorted((value, one) for value, one in zip(values, shown) if numpy.isfinite(value))
    assert [one for _, one in pairs] == sorted(one for _, one in pairs)
    if min(finite) < max(finite):
        assert (pairs[0][1], pairs[-1][1]) == (0, 255)


def test_colours_of_sixteen_bits_keep_their_upper_half() -> None:
    image = numpy.array([[[0x1234, 0xABCD, 0x00FF]]], numpy.uint16)
    made = convert(message("bgr16", image, 0, True))
    assert made.pixels.tolist() == [[[0x00, 0xAB, 0x12]]]
    assert made.notes == ["upper 8 of 16 bits"]


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
@pytest.mark.parametrize("bits", [8, 16])
def test_bayer_block_becomes_a_pixel(pattern: str, bits: int) -> None:
    levels = {"r": [200], "g": [100, 51], "b": [7]}
    left = {colour: list(values) for colour, values in levels.items()}
    block = [left[colour].pop(0) for colour in pattern]
    image = numpy.array(block, numpy.uint8).reshape(2, 2, 1)
    image = numpy.tile(image, (2, 3, 1))[:3, :5]  # the odd row and column are left out
    wide = image if bits == 8 else image.astype(numpy.uint16) << 8
    made = convert(message(f"bayer_{pattern}{bits}", wide))
    assert made.pixels.tolist() == [[[200, 75, 7]] * 2]
    assert made.notes[-1] == "demosaiced at half of the resolution"


@pytest.mark.parametrize("every", [2, 3])
def test_large_image_is_subsampled_with_a_note(every: int) -> None:
    side = pixels.LONGEST_SIDE * (every - 1) + 1
    image = (numpy.arange(side) % 251).astype(numpy.uint8).reshape(1, side, 1)
    made = convert(message("mono8", image))
    assert (made.pixels[0, :, 0] == image[0, ::every, 0]).all()
    assert made.pixels.shape[1] <= pixels.LONGEST_SIDE
    assert made.notes == [f"subsampled by {every}"]
    # The range is that of all pixels.
    wide = numpy.zeros((1, side, 1), numpy.uint16)
    wide[0, 1] = 1000
    assert convert(message("mono16", wide)).notes[0] == "black 0 to white 1000"


def test_image_of_the_longest_side_is_whole() -> None:
    image = numpy.zeros((1, pixels.LONGEST_SIDE, 1), numpy.uint8)
    made = convert(message("mono8", image))
    assert made.pixels.shape[1] == pixels.LONGEST_SIDE and made.notes == []


def test_last_row_needs_no_padding() -> None:
    numbers = numpy.arange(12, dtype=numpy.uint8).reshape(2, 2, 3)
    image = message("rgb8", numbers, 3)
    assert (convert({**image, "data": image["data"][:-3]}).pixels == numbers).all()


@pytest.mark.parametrize(
    "changes, text",
    [
        ({"encoding": "yuv422"}, "unsupported encoding 'yuv422'; supported are mono, rgb,"),
        ({"encoding": "32FC2"}, "unsupported encoding '32FC2'"),
        ({"encoding": "32FC3"}, "unsupported encoding '32FC3'"),
        ({"encoding": "8FC1"}, "unsupported encoding '8FC1'"),
        ({"encoding": ""}, "unsupported encoding ''"),
        ({"width": 0}, "the image is empty: 0 × 2 pixels"),
        ({"height": 0}, "the image is empty: 3 × 0 pixels"),
        ({"step": 8}, "a row of 3 pixels takes 9 bytes, but step is 8"),
        ({"height": 3}, "the image takes 27 bytes, but the message has 18"),
        ({"encoding": "bayer_rggb8", "height": 1}, "a Bayer pattern needs at least 2 × 2 pixels"),
    ],
)
def test_image_that_cannot_be_shown_has_a_reason(changes: Dict[str, Any], text: str) -> None:
    image = message("rgb8", numpy.zeros((2, 3, 3), numpy.uint8))
    with pytest.raises(ImageProblem) as caught:
        convert({**image, **changes})
    assert text in str(caught.value)
