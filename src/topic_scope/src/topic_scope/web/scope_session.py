"""Session of a scope: its open pages and their data source; in the web thread."""

from typing import Any, AsyncIterator, Dict, List, Mapping, Sequence

import tornado.ioloop

from topic_scope.bag.overlay import BagOverlay
from topic_scope.page.csv_export import parts
from topic_scope.page.open_page import Page
from topic_scope.protocol import requests
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.image_request import ImageRequest
from topic_scope.protocol.options import Options
from topic_scope.sampling.recorder import OfferedField, Recorder
from topic_scope.web.data_source import DataSource
from topic_scope.web.field_selection import FieldSelection
from topic_scope.web.frame_sender import FrameSender
from topic_scope.web.handlers import PageSocket
from topic_scope.web.image_feed import ImageFeed, ImageReply
from topic_scope.web.overlay_loader import OverlayLoader
from topic_scope.web.trace_requests import TraceRequests

#: Time for the nodes of a launch file to start, before missing fields are logged [s].
WARN_AFTER_S = 5.0


class ScopeSession:
    """Connection of the pages with a data source.

    :param options: the command line
    :param source: the shown graph or bag
    :param bags: bags to overlay on it
    """

    def __init__(
        self, options: Options, source: DataSource, bags: Sequence[BagOverlay] = ()
    ) -> None:
        self.sockets: List[PageSocket] = []
        self._recorder = Recorder(source.source, source.layouts, options.history, bags)
        self._options, self._source = options, source
        self._knows_topics = self._is_halted = False
        self._choices: List[OfferedField] = []
        self._listed = choices_message([], {})
        loop = tornado.ioloop.IOLoop.current()
        self._overlays = OverlayLoader(bags, loop.add_callback, self._on_overlays)
        self._overlays.begin_at(source.begin)
        self._selection = FieldSelection(options.fields, self._recorder, self._overlays, self.pages)
        self._images = ImageFeed(self._recorder, self.pages, source.read_again, source.refresh)
        self.frames = FrameSender(self._recorder, self.sockets)
        source.start(self)
        own = TraceRequests(self._recorder, self._selection, self._overlays, source.refresh)
        self._handlers = {**own.handlers(), **self._images.handlers(), **source.handlers()}
        loop.call_later(WARN_AFTER_S, self._selection.log_problems)
        self.frames.start()

    # --- From the data source ----------------------------------------------------------------

    def on_topics(self, types: Mapping[str, str]) -> None:
        """Update the available fields, and the shown fields.

        :param types: type of each topic
        """
        types = {**types, **self._overlays.types}
        is_first, self._knows_topics = not self._knows_topics, True
        self.frames.has_samples = not self._is_halted
        self._recorder.set_topics(types)
        has_changed = self._selection.update_initial()
        choices = self._recorder.choices()
        for page in self.pages():
            if is_first:
                self._welcome(page)
            elif has_changed and page.chosen is None:
                page.put(self._hello())
            self._selection.select(page)
        if choices != self._choices:
            self._choices = choices
            self._listed = choices_message(choices, types)
            self.send_to_pages(self._listed)
        self._selection.record()
        self._images.update()

    def halt(self) -> None:
        """Drop all samples and send no frames until :meth:`resume`: the clock will jump."""
        self._is_halted, self.frames.has_samples = True, False
        self._recorder.forget()

    def resume(self) -> None:
        """Send frames again, from the present time of the clock."""
        self._is_halted, self.frames.has_samples = False, self._knows_topics
        now = self._recorder.update()
        for page in self.pages():
            page.restart(now)
        self._selection.pin()

    # --- From pages --------------------------------------------------------------------------

    def open(self, connection: PageSocket) -> Page:
        """Add a page; it receives its hello once the topics are known."""
        page = Page(self._options.window)
        self.sockets.append(connection)
        if self._knows_topics:
            self._welcome(page)
        else:  # until then it receives only the state of the master
            for message in self._source.messages():
                if message["type"] == "master":
                    page.put(message)
        return page

    def close(self, connection: PageSocket) -> None:
        """Remove a page."""
        if connection in self.sockets:
            self.sockets.remove(connection)
            if connection.page is not None:
                self._source.leave(connection.page)
            self._selection.pin()
            self._images.update()

    def export(self, names: Sequence[str], start: float, end: float) -> AsyncIterator[str]:
        """Return the parts of a CSV file.

        :param names: names of the fields
        :param start: start of the time span [s]
        :param end: end of the time span [s]
        """
        return parts(self._recorder, self._selection.expand(names), start, end)

    async def image(self, request: ImageRequest) -> ImageReply:
        """Return an image of a topic that a page shows."""
        return await self._images.reply(request)

    def handle(self, page: Page, text: Any) -> None:
        """Handle a request of a page, or send it the reason for a rejection.

        :param text: the request as received
        """
        try:
            requests.dispatch(text, self._handlers, page)
        except RequestError as error:
            page.put_once({"type": "error", "text": str(error)})

    # --- To pages ----------------------------------------------------------------------------

    def pages(self) -> List[Page]:
        """Return the open pages."""
        return [connection.page for connection in self.sockets if connection.page is not None]

    def send_to_pages(self, message: Dict[str, Any], *about: str) -> None:
        """Send a message to all pages.

        :param message: the message
        :param about: its subject; a later message of its type and subject replaces it
        """
        if self._knows_topics:
            for page in self.pages():
                page.put(message, *about)

    def _welcome(self, page: Page) -> None:
        page.put(self._hello())
        page.put(self._listed)
        for message in [*self._source.messages(), self._overlays.message()]:
            page.put(message)
        self._selection.select(page)
        self._selection.report_too_many(page)

    def _hello(self) -> Dict[str, Any]:
        return {
            "type": "hello",
            "protocol": requests.VERSION,
            "history": self._options.history,
            "fields": self._selection.initial,
            "defaults": {"window": self._options.window},
            "setup": self._options.setup,
            **self._source.hello(),
        }

    def _on_overlays(self) -> None:
        """Show new samples of overlaid bags, or their new positions."""
        for page in self.pages():
            page.show_again()
        self.send_to_pages(self._overlays.message())


def choices_message(choices: Sequence[OfferedField], types: Mapping[str, str]) -> Dict[str, Any]:
    """Return the message with the available fields.

    :param choices: the fields
    :param types: type of each topic
    """
    listed = [choice._asdict() for choice in choices]
    topics = {choice.topic: types.get(choice.topic, "*") for choice in choices}
    return {"type": "fields", "fields": listed, "types": topics}
