"""The oscilloscope between its pages and the graph; all of it runs in the thread of the web."""

from typing import Any, AsyncIterator, Dict, List, Optional, Sequence

import numpy
import tornado.ioloop

from topic_scope import protocol
from topic_scope.csv_rows import Column, header, rows
from topic_scope.fields import FieldError
from topic_scope.master_watch import GraphState, MasterWatch
from topic_scope.options import Options
from topic_scope.page import Page
from topic_scope.recorder import Choice, Recorder
from topic_scope.statistics import measure
from topic_scope.trigger import TriggerWatch
from topic_scope.web import Socket

#: Time between two frames, s.
FRAME_S = 0.025
#: Time between two measurements of the traces, s.
STATISTICS_S = 0.25
#: A file is made in parts of this length, s; frames are sent in between.
EXPORT_S = 0.25


class Server:
    """Serves all pages.

    :param recorder: has the samples
    :param options: the command line
    """

    def __init__(self, recorder: Recorder, options: Options) -> None:
        self.sockets: List[Socket] = []
        self._recorder = recorder
        self._options = options
        self._watch: Optional[MasterWatch] = None
        self._initial: List[str] = list(options.fields)
        self._choices: List[Choice] = []
        self._statistics_at = 0.0

    def start(self, watch: MasterWatch) -> None:
        """Begin to send frames.

        :param watch: is told when there is something to look at
        """
        self._watch = watch
        tornado.ioloop.PeriodicCallback(self._send_frames, FRAME_S * 1e3).start()

    # --- From the graph ----------------------------------------------------------------------

    def on_graph(self, state: GraphState) -> None:
        """Take note of what is on the graph."""
        self._recorder.set_topics(state.published_types)
        choices = self._recorder.choices()
        if choices != self._choices:
            self._choices = choices
            for each in self._pages():
                each.put(self._fields())
        initial = self._expanded(self._options.fields)
        if initial != self._initial:
            self._initial = initial
            for each in self._pages():
                if each.chosen is None:
                    each.put(self._hello())
        for each in self._pages():
            self._select(each)
        self._record()

    # --- From pages --------------------------------------------------------------------------

    def open(self, connection: Socket) -> Page:
        """Welcome a page."""
        page = Page(self._options.window)
        self.sockets.append(connection)
        page.put(self._hello())
        page.put(self._fields())
        self._select(page)
        return page

    def close(self, connection: Socket) -> None:
        """Forget a page."""
        if connection in self.sockets:
            self.sockets.remove(connection)

    async def export(self, names: Sequence[str], start: float, end: float) -> AsyncIterator[str]:
        """Return the rows of a CSV file, bit by bit.

        :param names: names of the fields
        :param start: begin of the time span, s
        :param end: end of the time span, s
        """
        now = self._recorder.update()
        begin, end = max(start, now - self._options.history), min(end, now)
        yield header(names)
        while begin <= end:
            stop = begin + EXPORT_S
            last = min(end, float(numpy.nextafter(stop, begin)))
            columns = [
                Column(self._recorder.topic_of(name), self._recorder.samples(name, begin, last))
                for name in names
            ]
            yield "".join(rows(columns))
            begin = stop

    def handle(self, page: Page, request: protocol.Request) -> None:
        """Do what a page asks for.

        :raises RequestError: if that cannot be done
        """
        if isinstance(request, protocol.Select):
            page.chosen = request.fields
            self._expanded(request.fields, page)
            self._select(page)
            page.view.restart()
            self._record()
            if self._watch is not None:
                self._watch.ring()
        elif isinstance(request, protocol.View):
            page.view.show(request)
        elif isinstance(request, protocol.Trigger):
            page.trigger = TriggerWatch(request, self._recorder.update())

    # -----------------------------------------------------------------------------------------

    def _pages(self) -> List[Page]:
        return [connection.page for connection in self.sockets if connection.page is not None]

    def _expanded(self, names: Sequence[str], page: Optional[Page] = None) -> List[str]:
        found: List[str] = []
        for name in names:
            try:
                found += [field for field in self._recorder.expand(name) if field not in found]
            except FieldError as error:
                if page is not None:
                    page.note({"type": "error", "text": "%s: %s" % (name, error)})
        return found[: protocol.TRACES]

    def _select(self, page: Page) -> None:
        names = self._initial if page.chosen is None else self._expanded(page.chosen)
        if list(names) != list(page.view.fields):
            page.view.select(list(names))

    def _record(self) -> None:
        names = set(self._initial).union(*(each.view.fields for each in self._pages()))
        self._recorder.want(names, self._recorder.update())

    def _hello(self) -> Dict[str, Any]:
        return {
            "type": "hello",
            "readonly": not self._options.is_local,
            "history": self._options.history,
            "fields": self._initial,
            "defaults": {"window": self._options.window},
        }

    def _fields(self) -> Dict[str, Any]:
        return {"type": "fields", "fields": [choice._asdict() for choice in self._choices]}

    def _send_frames(self) -> None:
        now = self._recorder.update()
        with_statistics = now >= self._statistics_at + STATISTICS_S
        if with_statistics:
            self._statistics_at = now
        for connection in list(self.sockets):
            page = connection.page
            if page is None:
                continue
            crossing = page.trigger.update(now, page.view.window, self._recorder.samples)
            if crossing is not None:
                page.put(crossing)
            if not connection.is_ready:
                continue  # the next frame holds what this one would have
            if with_statistics:
                page.put(self._statistics(page, now))
            messages = page.take()
            frame = page.view.frame(now, self._recorder.samples)
            connection.send(messages + ([frame] if frame is not None else []))

    def _statistics(self, page: Page, now: float) -> Dict[str, Any]:
        start, end = page.view.span(now)
        samples = self._recorder.samples
        traces = {field: measure(*samples(field, start, end)) for field in page.view.fields}
        return {"type": "stats", "traces": traces}
