"""Requests for images, as a page sends them."""

from typing import Dict

import pytest

from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.image_request import ImageRequest, image_request_of, image_topic_of


def test_topic_may_be_empty() -> None:
    assert image_topic_of({"topic": ""}) == "" and image_topic_of({"topic": "/a"}) == "/a"


@pytest.mark.parametrize("topic", [None, 3, "x" * 301])
def test_invalid_topic_is_rejected(topic: object) -> None:
    with pytest.raises(RequestError, match="images: topic must be a name"):
        image_topic_of({"topic": topic})


def test_time_and_known_image_are_optional() -> None:
    assert image_request_of({"topic": "/a"}) == ImageRequest("/a", None, "")
    query = {"topic": "/a", "time": "1700000000.25", "known": "7"}
    assert image_request_of(query) == ImageRequest("/a", 1700000000.25, "7")


@pytest.mark.parametrize("query", [{}, {"topic": ""}, {"topic": "/a", "time": "soon"}])
def test_invalid_query_is_rejected(query: Dict[str, str]) -> None:
    with pytest.raises(RequestError):
        image_request_of(query)
