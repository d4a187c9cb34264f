"""The oscilloscope between its pages and what it shows; all of it runs in the thread of the web."""

import time
import traceback
from typing import Any, AsyncIterator, Dict, List, Mapping, Optional, Sequence

import rospy
import tornado.ioloop

from topic_scope.bag.overlay import BagOverlay
from topic_scope.formulas.names import with_letters
from topic_scope.formulas.reading import FUNCTIONS
from topic_scope.masks.mask import Mask, MaskCheck
from topic_scope.messages.fields import FieldError
from topic_scope.page.export import parts
from topic_scope.page.measuring import left_out, warn_of
from topic_scope.page.page import Page
from topic_scope.page.trigger import TriggerWatch
from topic_scope.page.view import pinned
from topic_scope.protocol import computed, requests
from topic_scope.protocol.checks import TRACES, RequestError
from topic_scope.protocol.options import Options
from topic_scope.protocol.laying import overlay_of
from topic_scope.protocol.requests import Handler
from topic_scope.protocol.scaling import scaling_of
from topic_scope.record.recorder import Choice, Recorder
from topic_scope.web.origin import Origin
from topic_scope.web.overlays import Overlays
from topic_scope.web.web import Socket

#: Time between two frames, s.
FRAME_S = 0.025
#: How long the nodes of a launch file may take to start, until a field that is missing is named, s.
WARN_AFTER_S = 5.0
#: Time between two measurements of the traces, s: they cost as much as a dozen frames.
STATISTICS_S = 0.33
#: Time between two signs of life, s: a page that gets none for 10 s takes the connection for lost.
ALIVE_S = 1.0
_LOG_PERIOD_S = 10.0


class Server:
    """Serves all pages.

    :param options: the command line
    :param origin: where messages come from
    :param bags: what is laid over that
    """

    def __init__(self, options: Options, origin: Origin, bags: Sequence[BagOverlay] = ()) -> None:
        self.sockets: List[Socket] = []
        self._recorder = Recorder(origin.source, origin.layouts, options.history, bags)
        self._options, self._origin = options, origin
        self._knows_topics = False
        self._initial: List[str] = list(options.fields)
        self._choices: List[Choice] = []
        self._listed = choices_message([], {})
        self._statistics_at = 0.0
        self._is_halted = False
        loop = tornado.ioloop.IOLoop.current()
        self._overlays = Overlays(bags, loop.add_callback, self._on_overlays)
        self._overlays.begin_at(origin.begin)
        origin.start(self)
        self._handlers = {**self._own_handlers(), **origin.handlers()}
        loop.call_later(WARN_AFTER_S, self._warn)
        tornado.ioloop.PeriodicCallback(self._send_frames, FRAME_S * 1e3).start()
        tornado.ioloop.PeriodicCallback(self._send_alive, ALIVE_S * 1e3).start()

    # --- From the origin ---------------------------------------------------------------------

    def on_topics(self, types: Mapping[str, str]) -> None:
        """Take note of the topics that there are.

        :param types: type of each
        """
        types = {**types, **self._overlays.types}
        is_first, self._knows_topics = not self._knows_topics, True
        self._recorder.set_topics(types)
        initial = self._expanded(self._options.fields)
        has_changed, self._initial = initial != self._initial, initial
        choices = self._recorder.choices()
        for page in self.pages():
            if is_first:
                self._welcome(page)
            elif has_changed and page.chosen is None:
                page.put(self._hello())
            self._select(page)
        if choices != self._choices:
            self._choices = choices
            self._listed = choices_message(choices, types)
            self.send_to_pages(self._listed)
        self._record()

    def halt(self) -> None:
        """Forget all samples: the time will be another one. Pages get no frames till then."""
        self._is_halted = True
        self._recorder.forget()

    def resume(self) -> None:
        """Go on, at the time that it is now."""
        self._is_halted = False
        now = self._recorder.update()
        for page in self.pages():
            page.restart(now)
        self._pin()

    # --- From pages --------------------------------------------------------------------------

    def open(self, connection: Socket) -> Page:
        """Tell a page what there is, and welcome it as soon as it is known what can be shown."""
        page = Page(self._options.window)
        self.sockets.append(connection)
        if self._knows_topics:
            self._welcome(page)
        else:  # of all this, whether the master answers: so it knows that somebody is there
            for message in self._origin.messages():
                if message["type"] == "master":
                    page.put(message)
        return page

    def close(self, connection: Socket) -> None:
        """Forget a page."""
        if connection in self.sockets:
            self.sockets.remove(connection)
            if connection.page is not None:
                self._origin.leave(connection.page)
            self._pin()

    def export(self, names: Sequence[str], start: float, end: float) -> AsyncIterator[str]:
        """Return the parts of a CSV file.

        :param names: names of the fields
        :param start: start of the time span, s
        :param end: end of the time span, s
        """
        return parts(self._recorder, self._expanded(names), start, end)

    def handle(self, page: Page, text: Any) -> None:
        """Do what a page asks for, or tell it why not.

        :param text: the request as it came
        """
        try:
            requests.dispatch(text, self._handlers, page)
        except RequestError as error:
            page.put_once({"type": "error", "text": str(error)})

    def _own_handlers(self) -> Dict[str, Handler]:
        """Return what handles requests that are about the traces of a page."""
        return {
            "select": Handler(requests.selection_of, self._choose_fields),
            "formula": Handler(computed.formula_text_of, self._check_formula),
            "hide": Handler(requests.hidden_of, lambda page, fields: page.view.hide(fields)),
            "view": Handler(requests.view_of, self._show_view),
            "trigger": Handler(requests.trigger_of, self._set_trigger),
            "scaling": Handler(scaling_of, Page.scale),
            "measure": Handler(requests.measure_of, Page.set_measure),
            "chart": Handler(requests.chart_of, Page.set_chart),
            "mask": Handler(computed.mask_of, self._set_mask),
            "overlay": Handler(overlay_of, self._overlays.lay),
        }

    def _choose_fields(self, page: Page, fields: Sequence[str]) -> None:
        page.chosen = tuple(fields)
        self._expanded(fields, page)
        self._select(page)
        page.view.restart()
        self._record()
        self._origin.ring()

    def _check_formula(self, page: Page, typed: computed.FormulaText) -> None:
        """Tell a page what a formula would be called, or what is wrong with it."""
        told: Dict[str, Any] = {"type": "formula", "text": typed.text, "functions": list(FUNCTIONS)}
        told.update(name="", problem=None)
        try:
            (told["name"],) = self._recorder.expand(with_letters(typed.text, typed.traces))
            told["problem"] = self._recorder.problem(told["name"])
        except FieldError as error:
            told["problem"] = str(error)
        page.put(told)

    def _show_view(self, page: Page, view: requests.View) -> None:
        page.view.show(view)
        self._pin()

    def _set_trigger(self, page: Page, trigger: requests.Trigger) -> None:
        page.trigger = TriggerWatch(trigger, self._recorder.update())

    def _set_mask(self, page: Page, mask: Optional[Mask]) -> None:
        page.mask = None if mask is None else MaskCheck(mask, self._recorder.update())
        self._record()
        self._origin.ring()

    # --- To pages ----------------------------------------------------------------------------

    def pages(self) -> List[Page]:
        """Return the pages that are open."""
        return [connection.page for connection in self.sockets if connection.page is not None]

    def send_to_pages(self, message: Dict[str, Any], *about: str) -> None:
        """Tell all pages.

        :param message: the message
        :param about: what it is about; a later one of its type about the same replaces it
        """
        if self._knows_topics:
            for page in self.pages():
                page.put(message, *about)

    def _welcome(self, page: Page) -> None:
        page.put(self._hello())
        page.put(self._listed)
        for message in [*self._origin.messages(), self._overlays.message()]:
            page.put(message)
        self._select(page)
        count = len(self._all_of(self._options.fields))
        if count > TRACES:
            page.put_once({"type": "error", "text": left_out(count, TRACES)})

    def _hello(self) -> Dict[str, Any]:
        return {
            "type": "hello",
            "protocol": requests.VERSION,
            "history": self._options.history,
            "fields": self._initial,
            "defaults": {"window": self._options.window},
            "setup": self._options.setup,
            **self._origin.hello(),
        }

    def _warn(self) -> None:
        warn_of(self._recorder, self._all_of(self._options.fields), TRACES)

    def _expanded(self, names: Sequence[str], page: Optional[Page] = None) -> List[str]:
        """Return the fields that names stand for, as far as a page shows them."""
        found = self._all_of(names, page)
        if page is not None and len(found) > TRACES:
            page.put_once({"type": "error", "text": left_out(len(found), TRACES)})
        return found[:TRACES]

    def _all_of(self, names: Sequence[str], page: Optional[Page] = None) -> List[str]:
        """Return the fields that names stand for; those that stand for none stay as they are."""
        found: List[str] = []
        for name in names:
            try:
                found += [field for field in self._recorder.expand(name) if field not in found]
            except FieldError as error:
                found += [name] if name not in found else []
                if page is not None:
                    page.put_once({"type": "error", "text": f"{name}: {error}"})
        return found

    def _select(self, page: Page) -> None:
        names = self._initial if page.chosen is None else self._expanded(page.chosen)
        if list(names) != list(page.view.fields):
            page.view.select(list(names))
            if page.chosen is not None and list(names) != list(page.chosen):
                page.put({"type": "selected", "fields": list(names)})

    def _record(self) -> None:
        names = set(self._initial).union(*(page.view.fields for page in self.pages()))
        for page in self.pages():
            names.update(page.mask.mask.names if page.mask is not None else ())
        self._recorder.want(names, self._recorder.update())
        self._overlays.read_wanted()
        self._pin()

    def _on_overlays(self) -> None:
        """Show what has come of bags, or where they are now."""
        for page in self.pages():
            page.show_anew()
        self.send_to_pages(self._overlays.message())

    def _pin(self) -> None:
        """Keep what stands still on a page."""
        self._recorder.pin(pinned(page.view for page in self.pages()))

    def _send_alive(self) -> None:
        """Tell pages that the link is there, also where there is nothing to tell otherwise."""
        for connection in self.sockets:
            if connection.is_ready:
                connection.send([{"type": "alive"}])

    def _send_frames(self) -> None:
        now = self._recorder.update()
        if time.monotonic() >= self._statistics_at + STATISTICS_S:
            self._statistics_at = time.monotonic()
            for page in self.pages():
                page.is_to_measure = True
        for connection in list(self.sockets):
            if connection.page is None:
                continue
            try:
                if self._is_halted or not self._knows_topics:
                    if connection.is_ready:
                        connection.send(connection.page.pop_messages())
                else:
                    self._send_frame(connection, connection.page, now)
            except Exception:  # of any kind: the other pages have theirs all the same
                rospy.logerr_throttle(_LOG_PERIOD_S, f"no frame: {traceback.format_exc()}")

    def _send_frame(self, connection: Socket, page: Page, now: float) -> None:
        page.watch(self._recorder, now)
        began, used = time.monotonic(), time.thread_time()
        if connection.is_ready and page.is_due(began):  # the next frame holds what this one would
            measures, page.is_to_measure = page.is_to_measure, False
            connection.send(page.frame(self._recorder, now, measures))
            # By the processor: what others do on this machine is not the page's work.
            page.took(began, began + time.thread_time() - used)


def choices_message(choices: Sequence[Choice], types: Mapping[str, str]) -> Dict[str, Any]:
    """Return the message that tells what can be chosen.

    :param choices: the fields
    :param types: type of each topic
    """
    listed = [choice._asdict() for choice in choices]
    topics = {choice.topic: types.get(choice.topic, "*") for choice in choices}
    return {"type": "fields", "fields": listed, "types": topics}
