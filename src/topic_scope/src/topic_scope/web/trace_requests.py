"""Requests of pages about their traces: fields, formulas, view, trigger, mask."""

from typing import Any, Callable, Dict, Optional, Sequence

from topic_scope.formulas.names import with_letters
from topic_scope.formulas.parser import FUNCTIONS
from topic_scope.masks.mask_check import Mask, MaskCheck
from topic_scope.messages.fields import FieldError
from topic_scope.page.open_page import Page
from topic_scope.page.trigger import TriggerWatch
from topic_scope.protocol import formula_request, requests
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.clock_request import ClockRequest, clock_request_of
from topic_scope.protocol.overlay_request import overlay_of
from topic_scope.protocol.requests import Handler
from topic_scope.protocol.scaling import scaling_of
from topic_scope.sampling.recorder import Recorder
from topic_scope.web.field_selection import FieldSelection
from topic_scope.web.overlay_loader import OverlayLoader


class TraceRequests:
    """Handlers of the requests about a page's traces.

    :param recorder: recorder of the samples
    :param selection: the fields of all pages
    :param overlays: the overlaid bags
    :param refresh: makes the data source check immediately for new fields
    """

    def __init__(
        self,
        recorder: Recorder,
        selection: FieldSelection,
        overlays: OverlayLoader,
        refresh: Callable[[], None],
    ) -> None:
        self._recorder, self._selection = recorder, selection
        self._overlays, self._refresh = overlays, refresh

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers by type of request."""
        return {
            "select": Handler(requests.selection_of, self._choose_fields),
            "formula": Handler(formula_request.formula_text_of, self._check_formula),
            "hide": Handler(requests.hidden_of, lambda page, fields: page.view.hide(fields)),
            "view": Handler(requests.view_of, self._show_view),
            "trigger": Handler(requests.trigger_of, self._set_trigger),
            "scaling": Handler(scaling_of, Page.scale),
            "measure": Handler(requests.measure_of, Page.set_measure),
            "chart": Handler(requests.chart_of, Page.set_chart),
            "clock": Handler(clock_request_of, self._choose_clock),
            "mask": Handler(formula_request.mask_of, self._set_mask),
            "overlay": Handler(overlay_of, self._overlays.lay),
        }

    def _choose_fields(self, page: Page, fields: Sequence[str]) -> None:
        page.chosen = tuple(fields)
        self._selection.expand(fields, page)
        page.view.select(())  # so that the page learns what its names denote, even if unchanged
        self._selection.select(page)
        self._selection.record()
        self._refresh()

    def _choose_clock(self, _page: Page, wanted: ClockRequest) -> None:
        try:
            self._selection.choose_clock(wanted.topic, wanted.leader)
        except FieldError as error:
            raise RequestError(f"clock: {error}") from None

    def _check_formula(self, page: Page, typed: formula_request.FormulaText) -> None:
        """Send a page the name of a formula as a trace, or the problem with the formula."""
        reply: Dict[str, Any] = {
            "type": "formula",
            "text": typed.text,
            "functions": list(FUNCTIONS),
        }
        reply.update(name="", problem=None)
        try:
            (reply["name"],) = self._recorder.expand(with_letters(typed.text, typed.traces))
            reply["problem"] = self._recorder.problem(reply["name"])
        except FieldError as error:
            reply["problem"] = str(error)
        page.put(reply)

    def _show_view(self, page: Page, view: requests.View) -> None:
        page.view.show(view)
        self._selection.pin()

    def _set_trigger(self, page: Page, trigger: requests.Trigger) -> None:
        page.trigger = TriggerWatch(trigger, self._recorder.update())

    def _set_mask(self, page: Page, mask: Optional[Mask]) -> None:
        page.mask = None if mask is None else MaskCheck(mask, self._recorder.update())
        self._selection.record()
        self._refresh()
