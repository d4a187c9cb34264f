"""Requests for CSV files: accepted, or rejected with a reason."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.export_request import Export, export_of


def test_export_without_a_span_has_all_samples() -> None:
    assert export_of({"fields": ["/a/x"]}) == Export(("/a/x",), 0.0, 1e11)
    asked = {"fields": ["/a/x", "/b"], "start": "10", "end": "12.5"}
    assert export_of(asked) == Export(("/a/x", "/b"), 10.0, 12.5)


def test_invalid_name_has_a_column_beside_a_valid_one() -> None:
    assert export_of({"fields": ["/a/x", "a b"]}).fields == ("/a/x", "a b")
    with pytest.raises(RequestError, match="fields: "):
        export_of({"fields": ["a b", "c d"]})


@pytest.mark.parametrize("time", ["", "now", "nan", "1e99", None, []])
def test_invalid_time_is_rejected(time: Any) -> None:
    with pytest.raises(RequestError, match="a time must be a number of seconds"):
        export_of({"fields": ["/a/x"], "start": time})


ANYTHING = st.none() | st.text(max_size=8) | st.floats() | st.lists(st.text(max_size=8), max_size=3)


@settings(max_examples=30)
@given(st.dictionaries(st.sampled_from(["fields", "start", "end"]), ANYTHING))
def test_any_request_is_accepted_or_rejected(request: Any) -> None:
    try:
        wanted = export_of(request)
    except RequestError:
        return
    assert 0.0 <= wanted.start <= 1e11 and 0.0 <= wanted.end <= 1e11
