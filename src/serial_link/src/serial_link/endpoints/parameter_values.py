# Pure: knows no ROS.
"""Conversion of a parameter to the types that a board accepts. Pure."""

import math
import struct
from typing import Any, List

from serial_link.negotiation.payloads import Values, encode_values

_INT32 = range(-(2**31), 2**31)


class UnsupportedValue(ValueError):
    """A parameter that no board can take; the text says why."""


def encode_answer(raw: Any, size: int) -> bytes:
    """Return the payload that answers a board's request for a parameter.

    :param raw: as the parameter server holds it
    :param size: what the board's buffer holds [bytes]
    :raises UnsupportedValue: if it is nothing that a board takes, or too long
    """
    payload = encode_values(to_values(raw))
    if len(payload) > size:
        raise UnsupportedValue(
            f"an answer of {len(payload)} bytes is not sent: the board's buffer has {size}"
        )
    return payload


def to_values(raw: Any) -> Values:
    """Return the value of a parameter as the answer to a board.

    Whole numbers are among the floats too: YAML reads ``1`` for the gain that a sketch asks for as
    a float.

    :param raw: as the parameter server holds it
    :raises UnsupportedValue: if it is neither a number, a Boolean, a text nor a list of these
    """
    values: List[Any] = list(raw) if isinstance(raw, (list, tuple)) else [raw]
    if all(isinstance(value, str) for value in values):
        return Values(texts=values)
    if not all(isinstance(value, (bool, int, float)) for value in values):
        raise UnsupportedValue("it must be a number, true or false, text, or a list of one kind")
    floats = [_as_float32(value) for value in values]
    if not all(math.isfinite(value) for value in floats):
        raise UnsupportedValue("it does not fit into a 32-bit float")
    ints = [int(value) for value in values if not isinstance(value, float) and value in _INT32]
    return Values(ints if len(ints) == len(values) else (), floats)


def _as_float32(value: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.inf
