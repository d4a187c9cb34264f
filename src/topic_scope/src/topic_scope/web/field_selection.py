"""Resolution of the names on pages and the command line to fields, and their recording."""

from typing import Callable, List, Optional, Sequence

from topic_scope.messages.fields import FieldError
from topic_scope.page.open_page import Page
from topic_scope.page.statistics_table import left_out, warn_of
from topic_scope.page.view import pinned
from topic_scope.protocol.checks import TRACES
from topic_scope.sampling.recorder import Recorder
from topic_scope.web.overlay_loader import OverlayLoader


class FieldSelection:
    """Fields of all pages: resolves names, and requests the fields from the recorder.

    :param names: names of the command line, shown by pages without a selection
    :param recorder: recorder of the samples
    :param overlays: loader of overlaid bags
    :param pages: returns the open pages

    :ivar initial: fields that the names of the command line currently denote
    """

    def __init__(
        self,
        names: Sequence[str],
        recorder: Recorder,
        overlays: OverlayLoader,
        pages: Callable[[], List[Page]],
    ) -> None:
        self.initial: List[str] = list(names)
        self._names, self._recorder, self._overlays, self._pages = names, recorder, overlays, pages

    def update_initial(self) -> bool:
        """Resolve the names of the command line again; return whether the result has changed."""
        before, self.initial = self.initial, self.expand(self._names)
        return self.initial != before

    def expand(self, names: Sequence[str], page: Optional[Page] = None) -> List[str]:
        """Return the fields that names denote, up to the limit of a page.

        :param page: receives a message about names that cannot be shown
        """
        found = self._expand_all(names, page)
        if page is not None:
            self._report_left_out(page, len(found))
        return found[:TRACES]

    def _expand_all(self, names: Sequence[str], page: Optional[Page] = None) -> List[str]:
        """Return the fields that names denote; unknown names are returned unchanged."""
        found: List[str] = []
        for name in names:
            try:
                found += [field for field in self._recorder.expand(name) if field not in found]
            except FieldError as error:
                found += [name] if name not in found else []
                if page is not None:
                    page.put_once({"type": "error", "text": f"{name}: {error}"})
        return found

    def select(self, page: Page) -> None:
        """Show on a page the fields that its names currently denote."""
        names = self.initial if page.chosen is None else self.expand(page.chosen)
        if list(names) != list(page.view.fields):
            page.view.select(list(names))
            if page.chosen is not None and list(names) != list(page.chosen):
                page.put({"type": "selected", "fields": list(names)})

    def record(self) -> None:
        """Record all fields that a page or its mask needs, and no others."""
        names = set(self.initial).union(*(page.view.fields for page in self._pages()))
        for page in self._pages():
            names.update(page.mask.mask.names if page.mask is not None else ())
        self._recorder.want(names, self._recorder.update())
        self._overlays.read_wanted()
        self.pin()

    def choose_clock(self, topic: str, leader: str) -> None:
        """Place the samples of a topic by the clock of another topic, on all pages.

        :param leader: the other topic; empty to estimate the clock
        :raises FieldError: if a topic does not have a clock
        """
        self._recorder.streams.choose_clock(topic, leader)
        for page in self._pages():
            page.show_again()
        self.pin()

    def pin(self) -> None:
        """Keep the samples that a paused page shows."""
        self._recorder.pin(pinned(page.view for page in self._pages()))

    def report_too_many(self, page: Page) -> None:
        """Notify a page if the command line names more fields than a page shows."""
        self._report_left_out(page, len(self._expand_all(self._names)))

    def log_problems(self) -> None:
        """Log the problems of the fields of the command line."""
        warn_of(self._recorder, self._expand_all(self._names), TRACES)

    @staticmethod
    def _report_left_out(page: Page, count: int) -> None:
        if count > TRACES:
            page.put_once({"type": "error", "text": left_out(count, TRACES)})
