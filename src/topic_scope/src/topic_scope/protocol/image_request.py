# Pure: knows no ROS.
"""Requests of a page for images: the topic that it shows, and the image at a time."""

from typing import Any, Dict, NamedTuple, Optional

from topic_scope.protocol.checks import name_of, time_of


class ImageRequest(NamedTuple):
    """Request for an image.

    :param topic: its topic
    :param time: s since the epoch; None for the newest
    :param known: name of the image that the page already has; empty for none
    """

    topic: str
    time: Optional[float]
    known: str


def image_topic_of(request: Dict[str, Any]) -> str:
    """Return the topic whose images a page shows; empty for none."""
    return "" if request.get("topic") == "" else name_of(request, "images", "topic")


def image_request_of(query: Dict[str, Any]) -> ImageRequest:
    """Return the requested image.

    :param query: parameters of a URL: ``topic``, and optionally ``time`` and ``known``
    :raises RequestError: if the query is invalid
    """
    time = time_of(query["time"]) if query.get("time") else None
    return ImageRequest(name_of(query, "image", "topic"), time, str(query.get("known", "")))
