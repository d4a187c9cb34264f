"""Tests of requests and responses of the client of another node's parameters."""

from typing import Any

import numpy
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from nodekit.node.parameter_client import request_text

NUMBERS = st.booleans() | st.integers(-(2**31), 2**31 - 1) | st.floats(allow_nan=False)
VALUES = NUMBERS | st.text(max_size=8) | st.lists(NUMBERS, max_size=3)


@given(st.dictionaries(st.text(min_size=1, max_size=5), VALUES, max_size=4))
def test_request_text_round_trips(values: Any) -> None:
    assert yaml.safe_load(request_text(values)) == values


def test_repeated_value_is_written_twice() -> None:
    same = [1.0, 2.0]
    text = request_text({"xs": same, "ys": same})
    assert "&" not in text and "*" not in text
    assert yaml.safe_load(text) == {"xs": same, "ys": same}


@pytest.mark.parametrize(
    "value, sent",
    [
        ((1, 2), [1, 2]),
        (b"\x01\xff", [1, 255]),
        (numpy.bool_(True), True),
        (numpy.str_("a"), "a"),
        (numpy.array([1.5, 2.0]), [1.5, 2.0]),
        ([numpy.float32(0.5), 1], [0.5, 1]),
    ],
)
def test_values_are_sent_as_the_server_has_them(value: Any, sent: Any) -> None:
    assert yaml.safe_load(request_text({"a": value})) == {"a": sent}


def test_unsupported_value_is_refused() -> None:
    with pytest.raises(ValueError, match="not a value of a parameter"):
        request_text({"a": object()})
