"""Images that a session sends to its pages, or the reasons why they are missing."""

import asyncio
import threading
from typing import Any, Coroutine, Dict, Iterator, List, Optional, Tuple
from unittest import mock

import pytest
import std_msgs.msg
from bags import serialized
from rospy import Time
from sensor_msgs.msg import Image

from topic_scope.messages.arrays import Arrays
from topic_scope.messages.layout_cache import Layouts
from topic_scope.messages.message_layout import layout_of
from topic_scope.page.open_page import Page
from topic_scope.protocol.image_request import ImageRequest
from topic_scope.sampling import image_history
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, to_ns
from topic_scope.web import image_feed
from topic_scope.web.image_feed import ImageFeed, ImageReply

TOPIC, NOW = "/camera/image", 1700000000.0
TYPES = {TOPIC: "sensor_msgs/Image", "/x": "std_msgs/Float64"}


class Source:
    """Message source controlled by a test."""

    has_ended = False

    def __init__(self) -> None:
        self.time = NOW
        self.wanted: List[str] = []
        self.needs_past = False
        self.clock = self
        self._batches: List[Batch] = []

    def now(self) -> float:
        return self.time

    def want(self, topics: List[str], is_more: bool = False) -> None:
        self.wanted, self.needs_past = list(topics), is_more

    def subscriptions(self) -> Dict[str, Any]:
        return {TOPIC: self} if TOPIC in self.wanted else {}

    def drain(self) -> List[Batch]:
        batches, self._batches = self._batches, []
        return batches

    def send(self, grey: int, delay: float = 0.0, stamp: Optional[float] = None) -> None:
        """Send an image of one pixel.

        :param grey: its value
        :param delay: from the stamp to the receipt [s]
        :param stamp: s; by default the time
        """
        when = to_ns(self.time) - to_ns(delay) if stamp is None else to_ns(stamp)
        header = std_msgs.msg.Header(stamp=Time(*divmod(when, NS)))
        message = Image(header, 1, 1, "mono8", 0, 1, bytes([grey]))
        connection = {
            **{"type": Image._type, "md5sum": Image._md5sum},
            "message_definition": Image._full_text,
        }
        self._batches.append(Batch(connection, [to_ns(self.time)], [serialized(message)]))


class Scope:
    """Recorder and feed with one page that shows the images."""

    def __init__(self, read_again: Any = None) -> None:
        self.source, self.pages = Source(), [Page(5.0)]
        self.recorder = Recorder(self.source, Layouts(), 60.0)  # type: ignore[arg-type]
        self.recorder.set_topics(TYPES)
        self.refresh = mock.Mock()
        self.feed = ImageFeed(self.recorder, lambda: self.pages, read_again, self.refresh)
        self.choose(self.pages[0], TOPIC)

    def choose(self, page: Page, topic: str) -> None:
        handler = self.feed.handlers()["images"]
        handler.handle(page, handler.check({"topic": topic}))

    def send(self, *greys: int, **options: Any) -> None:
        """Send an image each second."""
        for grey in greys:
            self.source.time += 1.0
            self.source.send(grey, **options)
            self.recorder.update()

    def reply(self, time: Optional[float] = None, known: str = "") -> ImageReply:
        return run(self.feed.reply(ImageRequest(TOPIC, time, known)))

    def text(self, time: Optional[float] = None) -> str:
        """Return the reason why there is no image."""
        description, file = self.reply(time)
        assert file is None
        return str(description["problem"])


def run(work: "Coroutine[Any, Any, ImageReply]") -> ImageReply:
    return asyncio.get_event_loop().run_until_complete(work)


@pytest.fixture(autouse=True)
def loop() -> Iterator[None]:
    made = asyncio.new_event_loop()
    asyncio.set_event_loop(made)
    yield
    asyncio.set_event_loop(None)
    made.close()


@pytest.fixture(autouse=True)
def converted() -> Iterator[List[Tuple[int, str]]]:
    """Yield the grey values of converted images, with the converting threads."""
    done: List[Tuple[int, str]] = []

    def convert(_layout: Any, message: bytes) -> Any:
        done.append((message[-1], threading.current_thread().name))
        return image_feed.ShownImage("image/png", message[-1:], f"grey {message[-1]}")

    with mock.patch("topic_scope.web.image_feed.shown_image", convert):
        yield done


def test_reply_has_the_image_at_the_time_or_the_newest(converted: List[Tuple[int, str]]) -> None:
    scope = Scope()
    scope.send(1, 2, 3, delay=0.25)
    for time, grey in ((NOW + 0.75, 1), (NOW + 1.74, 1), (NOW + 1.75, 2), (NOW + 9.0, 3)):
        description, file = scope.reply(time)
        assert file is not None and file.data == bytes([grey])
        assert description["time"] == pytest.approx(NOW + grey - 0.25, abs=1e-6)
        assert description["text"] == f"grey {grey}" and description["correction"] is None
    assert scope.reply()[1] == scope.reply(NOW + 9.0)[1]
    assert scope.text(NOW + 0.7) == "no image at this time: the first is 0.05 s after it"
    # Not in the requesting thread, and once for all pages.
    assert [grey for grey, _ in converted] == [1, 2, 3]
    assert all(name.startswith("images") for _, name in converted)


def test_images_of_two_topics_received_at_once_are_told_apart() -> None:
    scope, other = Scope(), Scope()
    scope.send(1)
    other.send(2)
    scopes = {TOPIC: scope.recorder.images(TOPIC), "/other": other.recorder.images(TOPIC)}
    with mock.patch.object(scope.recorder, "images", scopes.__getitem__):
        files = [run(scope.feed.reply(ImageRequest(topic, None, ""))).file for topic in scopes]
    assert [file and file.data for file in files] == [b"\1", b"\2"]


def test_image_of_another_clock_is_placed_like_a_trace(converted: List[Tuple[int, str]]) -> None:
    scope = Scope()
    scope.recorder.want(["/camera/image/height"], NOW)
    for second in range(4):
        scope.send(second, stamp=50.0 + second)
    times, _ = scope.recorder.samples("/camera/image/height", 0.0, 1e10)
    description, file = scope.reply(float(times[1]))
    assert file is not None and file.data == b"\1"
    assert description["time"] == pytest.approx(times[1], abs=1e-6)
    assert description["correction"] == "stamps of another clock: shown at reception"
    text = "no image at this time: the first is 0.25 s after it"
    assert scope.text(float(times[0]) - 0.25) == text


def test_image_is_found_by_its_own_time() -> None:
    scope = Scope()
    for place in range(20):
        scope.send(place, delay=0.123456789 + place * 1e-7)  # rounded to a float, up or down
    for place in range(20):
        time = scope.reply(NOW + place + 1.0).description["time"]
        assert scope.reply(time).description["time"] == time


def test_image_that_the_page_has_is_not_sent_again(converted: List[Tuple[int, str]]) -> None:
    scope = Scope()
    scope.send(1)
    known = scope.reply().description["known"]
    description, file = scope.reply(known=known)
    assert file is None and "problem" not in description and description["known"] == known
    scope.send(2)
    assert scope.reply(known=known)[1] is not None


def test_topic_is_requested_only_while_a_page_shows_it() -> None:
    scope = Scope()
    assert scope.source.wanted == [TOPIC] and scope.source.needs_past
    scope.feed.update()
    assert scope.source.wanted == [TOPIC] and not scope.source.needs_past
    assert scope.text() == "no image has been received yet"
    other = Page(5.0)
    scope.pages.append(other)
    scope.choose(other, TOPIC)
    scope.choose(scope.pages[0], "")
    assert scope.source.wanted == [TOPIC]
    scope.pages.remove(other)  # closed
    scope.feed.update()
    assert scope.source.wanted == []
    assert scope.text() == f"images of {TOPIC} are not received: no page shows them"


def test_topic_that_appears_later_is_requested() -> None:
    scope = Scope()
    scope.choose(scope.pages[0], "/later")
    assert scope.source.wanted == []
    description, _ = run(scope.feed.reply(ImageRequest("/later", None, "")))
    assert description["problem"] == "the topic /later does not exist yet"
    scope.recorder.set_topics({**TYPES, "/later": "sensor_msgs/Image"})
    scope.feed.update()
    assert scope.source.wanted == ["/later"]
    # Its images stay if its publisher ends.
    scope.recorder.set_topics(TYPES)
    scope.feed.update()
    assert scope.source.wanted == ["/later"]


def test_dropped_image_is_read_again_or_has_a_reason(
    monkeypatch: "pytest.MonkeyPatch", converted: List[Tuple[int, str]]
) -> None:
    monkeypatch.setattr(image_history, "MOST_BYTES", 1)
    scope = Scope()
    scope.send(1, 2, 3)
    assert scope.text(NOW + 1.0) == (
        "the image at this time was dropped: the scope keeps 128 MB of images, from 2 s after it"
    )
    read_again = mock.Mock(return_value=b"again\7")
    scope = Scope(read_again)
    scope.send(1, 2)
    _, file = scope.reply(NOW + 1.0)
    assert file is not None and file.data == b"\7"
    read_again.assert_called_once_with(TOPIC, to_ns(NOW + 1.0))


@pytest.mark.parametrize("delay", [0.0, 1000.0])
def test_images_of_paused_pages_are_dropped_last(
    monkeypatch: "pytest.MonkeyPatch", delay: float
) -> None:
    scope = Scope()
    scope.send(1, delay=delay)
    size = len(serialized(Image(encoding="mono8", data=b"x")))
    monkeypatch.setattr(image_history, "MOST_BYTES", 3 * size)
    scope.choose(scope.pages[0], "")
    scope.choose(scope.pages[0], TOPIC)
    scope.send(2, 3, delay=delay)
    scope.pages.append(Page(5.0))
    scope.choose(scope.pages[1], TOPIC)
    for page, start in zip(scope.pages, (1.5, 2.5)):
        page.view.pinned = (NOW + start, NOW + start + 0.5)
    scope.reply()
    scope.send(4, 5, 6, delay=delay)
    assert scope.reply(NOW + 2.0)[1] is not None and scope.reply(NOW + 3.0)[1] is not None
    assert scope.text(NOW + 4.0).endswith("was dropped: the scope keeps 128 MB of images")
    scope.pages[0].view.pinned = scope.pages[1].view.pinned = None
    scope.reply()
    scope.send(7, 8, 9, delay=delay)
    assert "was dropped" in scope.text(NOW + 3.0)
    assert scope.reply(NOW + 7.0)[1] is not None


def test_image_that_cannot_be_shown_has_its_time_and_the_reason() -> None:
    scope = Scope()
    scope.send(1)
    problem = image_feed.ImageProblem("unsupported encoding 'x'")
    with mock.patch("topic_scope.web.image_feed.shown_image", side_effect=problem):
        description, file = scope.reply()
    assert file is None and description["problem"] == "unsupported encoding 'x'"
    assert description["time"] == pytest.approx(NOW + 1.0, abs=1e-6)
    assert scope.reply()[1] is not None  # the next request succeeds


def test_choice_of_a_topic_is_passed_on_at_once() -> None:
    scope = Scope()
    scope.refresh.assert_called_once_with()


def test_images_of_an_overlaid_bag_are_not_recorded() -> None:
    scope, topic = Scope(), "/old/camera"
    overlay = mock.Mock(layouts={topic: layout_of(Image)}, arrays={topic: Arrays()})
    made = Recorder(scope.source, Layouts(), 60.0, [overlay])  # type: ignore[arg-type]
    made.set_topics({topic: "sensor_msgs/Image"})
    made.want_images([topic])
    assert made.images(topic) is None and scope.source.wanted == []


def test_jump_of_the_clock_drops_all_images() -> None:
    scope = Scope()
    scope.send(1)
    scope.recorder.forget()
    assert scope.text() == "no image has been received yet"
    scope.send(2)
    assert scope.reply()[1] is not None
