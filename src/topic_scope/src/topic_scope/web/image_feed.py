"""Images of the topics that pages show: selected by time, converted outside the web thread."""

import asyncio
import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

from topic_scope.bag.recording import BagError
from topic_scope.images.pixels import ImageProblem
from topic_scope.images.shown_image import ShownImage, shown_image
from topic_scope.page.open_page import Page
from topic_scope.protocol.image_request import ImageRequest, image_topic_of
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.image_history import MOST_BYTES, ImageHistory, StoredImage
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, ROUNDED_NS, shifted, to_ns

_NEVER = (math.inf, -math.inf)
#: Function that reads a dropped message again, by topic and time of receipt [ns]; None if lost.
ReadAgain = Callable[[str, int], Optional[bytes]]


class ImageReply(NamedTuple):
    """Reply to a request for an image.

    :param description: ``time`` [s] of the image, ``known`` (its name), ``text`` (its description)
        and ``correction`` of its stamp, or ``problem``, the reason why there is no image
    :param file: the image; None if there is a problem, or the page already has it
    """

    description: Dict[str, Any]
    file: Optional[ShownImage] = None


class ImageFeed:
    """Images of the topics that pages show; a topic is recorded only while a page shows it.

    All methods are for the web thread; images are converted in another one, one at a time.

    :param recorder: recorder of the messages
    :param pages: function that returns the open pages
    :param read_again: reader of dropped messages; None if they are lost, as on a live graph
    :param refresh: function that makes the data source check immediately for new topics
    """

    def __init__(
        self,
        recorder: Recorder,
        pages: Callable[[], List[Page]],
        read_again: Optional[ReadAgain],
        refresh: Callable[[], None],
    ) -> None:
        self._recorder, self._pages = recorder, pages
        self._read_again, self._refresh = read_again, refresh
        self._converter = ThreadPoolExecutor(1, "images")
        #: The latest converted image, for several pages, by topic and time of receipt.
        self._latest: Tuple[Tuple[str, int], Optional[ShownImage]] = (("", 0), None)

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers by type of request."""
        return {"images": Handler(image_topic_of, self._choose)}

    def _choose(self, page: Page, topic: str) -> None:
        page.image_topic = topic
        self.update()
        self._refresh()

    def update(self) -> None:
        """Request the existing topics among those that pages show."""
        self._recorder.want_images({page.image_topic for page in self._pages()} - {""})
        self.pin()

    def pin(self) -> None:
        """Pin the images in view of paused pages, so that they are dropped last."""
        spans: Dict[str, Tuple[float, float]] = {}
        for page in self._pages():
            if page.view.pinned is not None:
                start, end = page.view.pinned
                before = spans.get(page.image_topic, (start, end))
                spans[page.image_topic] = min(start, before[0]), max(end, before[1])
        for topic in {page.image_topic for page in self._pages()}:
            found = self._recorder.images(topic)
            if found is not None:
                images, stream = found
                start, end = map(to_ns, spans.get(topic, _NEVER))
                images.pin(shifted(start, -stream.offset), shifted(end, -stream.offset))

    async def reply(self, request: ImageRequest) -> ImageReply:
        """Return the image at a time, converted for a browser."""
        self.pin()
        found = self._recorder.images(request.topic)
        if found is None:
            return _problem(self._why_unknown(request.topic))
        images, stream = found
        image = images.newest
        if request.time is not None:
            image = images.at(to_ns(request.time) + ROUNDED_NS - stream.offset)
        if image is None:
            return _problem(_why_none(images, request.time, stream.offset))
        place = (image.time + stream.offset) / NS
        described = {"time": place, "known": str(image.received), "correction": stream.correction}
        if request.known == described["known"]:
            return ImageReply(described)
        try:
            file = await self._converted(request.topic, image)
        except (ImageProblem, BagError) as error:
            return ImageReply({**described, "problem": str(error)})
        if file is None:
            return _problem(_why_dropped(images, place, stream.offset))
        return ImageReply({**described, "text": file.text}, file)

    async def _converted(self, topic: str, image: StoredImage) -> Optional[ShownImage]:
        """Return an image for a browser; None if its message was dropped.

        :raises ImageProblem: if it cannot be shown
        :raises BagError: if its bag is damaged
        """
        key = topic, image.received
        if self._latest[0] != key:
            read_again = self._read_again

            def convert() -> Optional[ShownImage]:
                message = image.message
                if message is None and read_again is not None:
                    message = read_again(topic, image.received)
                return None if message is None else shown_image(image.layout, message)

            loop = asyncio.get_event_loop()
            self._latest = key, await loop.run_in_executor(self._converter, convert)
        return self._latest[1]

    def _why_unknown(self, topic: str) -> str:
        if self._recorder.is_overlaid(topic):
            return "images of an overlaid bag cannot be shown; show the bag itself with --bag"
        if self._recorder.is_known(topic):
            return f"images of {topic} are not received: no page shows them"
        return f"the topic {topic} does not exist yet"


def _problem(text: str) -> ImageReply:
    return ImageReply({"problem": text})


def _why_none(images: ImageHistory, time: Optional[float], offset: int) -> str:
    """Return why there is no image at a time."""
    if time is None or images.first is None:
        return "no image has been received yet"
    return (
        f"no image at this time: the first is {(images.first + offset) / NS - time:.3g} s after it"
    )


def _why_dropped(images: ImageHistory, time: float, offset: int) -> str:
    """Return why an image can no longer be shown."""
    first = images.first_kept
    after = 0.0 if first is None else (first + offset) / NS - time
    kept = f", from {after:.3g} s after it" if after > 0.0 else ""  # not of a paused view before
    most = f"{MOST_BYTES // 10**6} MB of images"
    return f"the image at this time was dropped: the scope keeps {most}{kept}"
