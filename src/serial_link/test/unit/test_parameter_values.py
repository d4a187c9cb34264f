"""A parameter as a board can take it."""

from typing import Any

import pytest

from serial_link.endpoints.parameter_values import UnsupportedValue, encode_answer, to_values
from serial_link.negotiation.payloads import decode_values


@pytest.mark.parametrize(
    "raw, ints, floats, texts",
    [
        (3, [3], [3.0], []),
        (True, [1], [1.0], []),
        (0.5, [], [0.5], []),
        ([1, 2], [1, 2], [1.0, 2.0], []),
        ([1, 2.5], [], [1.0, 2.5], []),
        ("text", [], [], ["text"]),
        (["a", "b"], [], [], ["a", "b"]),
        ([], [], [], []),
        (2**31 - 1, [2**31 - 1], [2.0**31], []),
        (-(2**31), [-(2**31)], [-(2.0**31)], []),
        (2**31, [], [2.0**31], []),
    ],
)
def test_numbers_and_texts(raw: Any, ints: Any, floats: Any, texts: Any) -> None:
    found = to_values(raw)
    assert [list(part) for part in found] == [ints, floats, texts]


@pytest.mark.parametrize("raw", [{"a": 1}, None, [1, "a"], [[1]], {}])
def test_unsupported_value_is_rejected(raw: Any) -> None:
    with pytest.raises(UnsupportedValue, match="must be a number"):
        to_values(raw)


@pytest.mark.parametrize("raw", [1e39, float("nan"), float("inf"), [0.0, -1e39]])
def test_value_beyond_float32_is_rejected(raw: Any) -> None:
    with pytest.raises(UnsupportedValue, match="32-bit"):
        to_values(raw)


def test_answer_fits_buffer_or_error_has_both_sizes() -> None:
    payload = encode_answer("x" * 84, 100)
    assert len(payload) == 100 and decode_values(payload).texts == ("x" * 84,)
    with pytest.raises(UnsupportedValue, match="of 101 bytes is not sent: .* buffer has 100"):
        encode_answer("x" * 85, 100)
