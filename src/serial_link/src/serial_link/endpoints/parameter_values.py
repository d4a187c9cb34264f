# Pure: knows no ROS.
"""Conversion of a parameter to the types that a board accepts."""

import math
import struct
from typing import Any, List

from serial_link.negotiation.payloads import ParameterValues, encode_values

_INT32 = range(-(2**31), 2**31)


class UnsupportedValue(ValueError):
    """A parameter that cannot be sent to a board; the text gives the reason."""


def encode_answer(raw: Any, size: int) -> bytes:
    """Return the payload that answers a board's parameter request.

    :param raw: the value from the parameter server
    :param size: size of the board's buffer [bytes]
    :raises UnsupportedValue: if a board cannot take the type, or the answer is too long
    """
    payload = encode_values(to_values(raw))
    if len(payload) > size:
        raise UnsupportedValue(
            f"an answer of {len(payload)} bytes is not sent: the board's buffer has {size}"
        )
    return payload


def to_values(raw: Any) -> ParameterValues:
    """Return the value of a parameter as an answer to a board.

    Integers are also sent as floats: the YAML may give ``1`` for a float that a sketch asks for.

    :param raw: the value from the parameter server
    :raises UnsupportedValue: if it is not a number, a Boolean, a string or a list of these
    """
    values: List[Any] = list(raw) if isinstance(raw, (list, tuple)) else [raw]
    if all(isinstance(value, str) for value in values):
        return ParameterValues(texts=values)
    if not all(isinstance(value, (bool, int, float)) for value in values):
        raise UnsupportedValue("it must be a number, true or false, text, or a list of one type")
    floats = [_as_float32(value) for value in values]
    if not all(math.isfinite(value) for value in floats):
        raise UnsupportedValue("it does not fit into a 32-bit float")
    ints = [int(value) for value in values if not isinstance(value, float) and value in _INT32]
    return ParameterValues(ints if len(ints) == len(values) else (), floats)


def _as_float32(value: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.inf
