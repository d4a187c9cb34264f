# Pure: knows no ROS.
"""Image message as a file that a browser shows."""

from typing import NamedTuple

from topic_scope.images.pixels import ImageProblem, convert
from topic_scope.images.png import to_png
from topic_scope.messages.message_layout import MessageLayout
from topic_scope.messages.message_reader import MessageReader, TruncatedMessage

#: Image types and their fields; a publisher may have another definition.
_FIELDS = {
    "sensor_msgs/Image": {
        "height": "uint32",
        "width": "uint32",
        "encoding": "string",
        "is_bigendian": "uint8",
        "step": "uint32",
        "data": "uint8[]",
    },
    "sensor_msgs/CompressedImage": {"format": "string", "data": "uint8[]"},
}
#: Types that can be shown.
TYPES = tuple(_FIELDS)
#: First bytes of compressed files that browsers decode, and their media types.
_FILES = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png"}


class ShownImage(NamedTuple):
    """File that a browser shows.

    :param media_type: e.g. ``image/png``
    :param data: the file
    :param text: description: size, encoding, and how it was converted
    """

    media_type: str
    data: bytes
    text: str


def shown_image(layout: MessageLayout, message: bytes) -> ShownImage:
    """Convert an image message.

    :param layout: layout of the message
    :param message: the serialized message
    :raises ImageProblem: if it cannot be shown
    """
    types = {name: field.datatype for name, field in layout.fields}
    if not types.items() >= _FIELDS.get(layout.datatype, {"": ""}).items():
        raise ImageProblem(
            f"{layout.datatype} is not an image type; supported are {' and '.join(TYPES)}"
        )
    try:
        image = MessageReader(layout).read(message)
    except TruncatedMessage as error:
        raise ImageProblem(str(error)) from None
    if layout.datatype == "sensor_msgs/CompressedImage":
        return _compressed(image["format"], image["data"].tobytes())
    pixels, notes = convert(image)
    size = f"{image['width']} × {image['height']}"
    return ShownImage("image/png", to_png(pixels), ", ".join([size, image["encoding"], *notes]))


def _compressed(name: str, data: bytes) -> ShownImage:
    for start, media_type in _FILES.items():
        if data.startswith(start):
            return ShownImage(media_type, data, f"{name[:60]}, {len(data) / 1000:.4g} kB")
    raise ImageProblem(f"unsupported format {name[:60]!r}; supported are JPEG and PNG files")
