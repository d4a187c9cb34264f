"""The precision of std_msgs/Float32."""

import struct

#: Largest finite value.
LARGEST = 3.4028234663852886e38


def to_float32(value: float) -> float:
    """Return the float32 next to a value, as a message would carry it.

    :param value: of a magnitude up to LARGEST
    """
    nearest: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return nearest
