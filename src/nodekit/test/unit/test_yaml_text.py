"""Tests of the bounded time of the YAML reader."""

import time

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from nodekit.parameters import yaml_text

#: Far above the time of a text below on a busy machine, and far below that of Python's own reader.
SOON_S = 5.0
SCALARS = st.booleans() | st.integers(-(2**31), 2**31 - 1) | st.text(max_size=8)
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=3), max_leaves=20)


@pytest.mark.parametrize(
    "text",
    ["{" * 20_000, "[" * 100_000, "- " * 50_000, "? " * 50_000, "{a:\n" * 20_000, "a: {" * 20_000],
    ids=lambda text: text[:4].strip(),
)
def test_deep_nesting_is_refused_quickly(text: str) -> None:
    began = time.monotonic()
    with pytest.raises(ValueError, match="at most 20 deep|invalid YAML"):
        yaml_text.load(text)
    assert time.monotonic() - began < SOON_S


@pytest.mark.parametrize("depth, is_taken", [(20, True), (21, False)])
def test_depth_is_counted_from_the_outermost(depth: int, is_taken: bool) -> None:
    text = f"[{'[' * (depth - 1)}{']' * (depth - 1)}, [1]]"
    if is_taken:
        assert yaml_text.load(text)[1] == [1]
    else:
        with pytest.raises(ValueError, match="at most 20 deep"):
            yaml_text.load(text)


@pytest.mark.parametrize("text", ["a: &a [*a]", "a: &a 1\nb: *a", "&a [1, *a]"])
def test_aliases_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="aliases"):
        yaml_text.load(text)


@pytest.mark.parametrize(
    "text", ["{", "a: [", "{[a]: 1}", "\0", "a: !!python/name:os.system x", '!!bool "x"']
)
def test_invalid_yaml_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(ValueError, match="invalid YAML: [^\n]+$"):
        yaml_text.load(text)


@given(st.dictionaries(st.text("abc", min_size=1), VALUES, max_size=4))
@example({"a": "\x85", "b": ["\u2028 ", "\u4f60"]})
def test_dumped_yaml_round_trips(values: object) -> None:
    assert (
        yaml_text.load(yaml_text.dump(values)) == yaml.safe_load(yaml_text.dump(values)) == values
    )


def test_unrepresentable_value_is_refused() -> None:
    with pytest.raises(ValueError, match="no YAML"):
        yaml_text.dump({"a": object()})
