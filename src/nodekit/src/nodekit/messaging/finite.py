# Pure: knows no ROS.
"""Search of a message for NaN and infinity, and rounding of a number to float32."""

import math
import struct
from typing import Any

#: Largest finite value of a float32 field.
LARGEST_FLOAT32 = (2.0 - 2.0**-23) * 2.0**127


def to_float32(value: float) -> float:
    """Return the nearest float32 of a value, as a message would carry it.

    :param value: a number of magnitude up to :data:`LARGEST_FLOAT32`
    """
    nearest: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return nearest


def is_finite(message: Any) -> bool:
    """Return whether a message has neither NaN nor infinity in any field.

    :param message: a message, or the value of a field
    """
    if isinstance(message, float):
        return math.isfinite(message)
    if isinstance(message, (int, str, memoryview)):  # no need to look inside
        return True
    if isinstance(message, (list, tuple)):
        return all(map(is_finite, message))
    if hasattr(message, "tolist"):  # numpy, or Python's array
        return is_finite(message.tolist())
    return all(is_finite(getattr(message, name)) for name in getattr(message, "__slots__", ()))
