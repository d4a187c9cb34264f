"""A parameter as a board can take it."""

from typing import Any

import pytest

from serial_link.endpoints.parameter_values import NotForBoards, values_of


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
    found = values_of(raw)
    assert [list(part) for part in found] == [ints, floats, texts]


@pytest.mark.parametrize("raw", [{"a": 1}, None, [1, "a"], [[1]], {}])
def test_what_no_board_takes_is_refused(raw: Any) -> None:
    with pytest.raises(NotForBoards, match="must be a number"):
        values_of(raw)


@pytest.mark.parametrize("raw", [1e39, float("nan"), float("inf"), [0.0, -1e39]])
def test_what_no_float_holds_is_refused(raw: Any) -> None:
    with pytest.raises(NotForBoards, match="32-bit"):
        values_of(raw)
