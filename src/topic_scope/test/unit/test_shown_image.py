"""Image messages as files for a browser."""

import numpy
import pytest
from bags import serialized
from sensor_msgs.msg import CompressedImage, Image, Imu
from test_pixels import decoded

from topic_scope.images.pixels import ImageProblem
from topic_scope.images.shown_image import shown_image
from topic_scope.messages.message_layout import layout_of, parse

JPEG, PNG = b"\xff\xd8\xff\xe0 and more", b"\x89PNG\r\n\x1a\n and more"


def test_image_becomes_a_png_file_with_its_description() -> None:
    message = Image(height=2, width=3, encoding="bgr8", step=9, data=bytes(range(18)))
    made = shown_image(layout_of(Image), serialized(message))
    assert made.media_type == "image/png" and made.text == "3 × 2, bgr8"
    expected = numpy.arange(18).reshape(2, 3, 3)[:, :, ::-1]
    assert (decoded(made.data) == expected).all()
    message.encoding = "8UC3"
    made = shown_image(layout_of(Image), serialized(message))
    assert made.text == "3 × 2, 8UC3, channels interpreted as bgr8"


@pytest.mark.parametrize("data, kind", [(JPEG, "image/jpeg"), (PNG, "image/png")])
def test_compressed_file_is_unchanged(data: bytes, kind: str) -> None:
    message = CompressedImage(format="bgr8; jpeg compressed bgr8", data=data)
    made = shown_image(layout_of(CompressedImage), serialized(message))
    assert (made.media_type, made.data) == (kind, data)
    assert made.text == f"bgr8; jpeg compressed bgr8, {len(data) / 1000:.4g} kB"


@pytest.mark.parametrize("data", [b"", b"GIF89a", bytes(12) + PNG])
def test_other_compressed_format_is_named(data: bytes) -> None:
    message = CompressedImage(format="16UC1; compressedDepth", data=data)
    with pytest.raises(ImageProblem) as caught:
        shown_image(layout_of(CompressedImage), serialized(message))
    text = "unsupported format '16UC1; compressedDepth'; supported are JPEG and PNG files"
    assert str(caught.value) == text


def test_truncated_message_and_other_types_have_a_reason() -> None:
    whole = serialized(Image(height=2, width=3, encoding="mono8", step=3, data=bytes(6)))
    with pytest.raises(ImageProblem, match="the message is cut off: an array ends beyond"):
        shown_image(layout_of(Image), whole[:-1])
    with pytest.raises(ImageProblem, match="sensor_msgs/Imu is not an image type; supported are s"):
        shown_image(layout_of(Imu), serialized(Imu()))
    number = Image._full_text.partition("=" * 80)[0].replace("string encoding", "int8 encoding")
    for other in ("uint32 height\nuint32 width\n", number.replace("Header", "uint32")):
        with pytest.raises(ImageProblem, match="sensor_msgs/Image is not an image"):
            shown_image(parse("sensor_msgs/Image", other), bytes(30))
