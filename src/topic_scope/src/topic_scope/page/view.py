# Pure: knows no ROS.
"""Visible time span of one page, with the decimated samples that it has or needs next."""

import math
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    FrozenSet,
    Iterable,
    List,
    Optional,
    Sequence,
    Tuple,
)

from topic_scope.analysis.decimation import FEW, all_bins, as_json, bin_of, lasts
from topic_scope.formulas.names import is_state
from topic_scope.protocol.requests import View
from topic_scope.protocol.scaling import ReadSamples

#: Returns the longest time between connected samples of a field [s].
GapLimit = Callable[[str], float]

#: Time after its end for which a paused page is still updated, because samples may be late [s]; and
#: how often it is checked for later samples after that.
LATE_S = 1.0


class LiveView:
    """View of one page; produces its frames.

    :param view: the time span to show
    """

    def __init__(self, view: View) -> None:
        self.fields: Sequence[str] = ()
        self._hidden: FrozenSet[str] = frozenset()
        self._view = view
        #: First bin that the page does not have completely; None if it has no bins.
        self._open: Optional[int] = None
        self._complete = False
        #: How often samples arrived after the view was complete.
        self.later = 0
        self._frame_at = 0.0
        #: Returns whether a field is stepped: its value holds until the next sample.
        self.stepped: Callable[[str], bool] = lambda _field: False
        #: Time span shown since the page was paused [s]; None while it moves.
        self.pinned: Optional[Tuple[float, float]] = None
        self._pin()

    def show(self, view: View) -> None:
        """Set the time span."""
        self._view = view
        self._pin()
        self.restart()

    def select(self, fields: Sequence[str]) -> None:
        """Set the fields."""
        self.fields = fields
        self.restart()

    def hide(self, fields: Collection[str]) -> None:
        """Set the hidden fields, which are not sent; unhidden fields are sent completely."""
        if self._hidden.difference(fields) & set(self.fields):
            self.restart()
        self._hidden = frozenset(fields)

    @property
    def shown(self) -> List[str]:
        """The visible numeric fields."""
        return [one for one in self.fields if one not in self._hidden and not is_state(one)]

    @property
    def states(self) -> List[str]:
        """The visible states."""
        return [one for one in self.fields if one not in self._hidden and is_state(one)]

    def restart(self) -> None:
        """Send all visible bins with the next frame."""
        self._open = None
        self._complete = False

    @property
    def window(self) -> float:
        """Length of the time span [s]."""
        return self._view.window

    @property
    def width(self) -> int:
        """Number of bins of the time span."""
        return self._view.width

    def span(self, now: float) -> Tuple[float, float]:
        """Return start and end of the visible span [s]."""
        end = now if self._view.end is None else self._view.end
        return end - self._view.window, end

    def _pin(self) -> None:
        if self._view.end is None:
            self.pinned = None
            return
        start, end = self._view.end - self._view.window, self._view.end + LATE_S
        before = self.pinned or (start, end)
        self.pinned = (min(start, before[0]), max(end, before[1]))

    def frame(
        self,
        now: float,
        read: ReadSamples,
        changed_since: Callable[[float], float],
        longest_step: GapLimit = lambda _field: math.inf,
    ) -> Optional[Dict[str, Any]]:
        """Return the bins that the page does not have yet.

        :param now: time up to which samples are complete [s]
        :param read: reader of the samples
        :param changed_since: returns the start of changes since an earlier time [s]
        :param longest_step: returns the longest time between connected samples [s]
        :returns: the frame; None if there are no new samples
        """
        stands_still = now == self._frame_at and self._open is not None
        if stands_still or (self._complete and now < self._frame_at + LATE_S):
            return None
        start, end = self.span(now)
        width = self._view.window / self._view.width
        last = bin_of(min(end, now), width)
        first, reset = self._open, False
        changed = changed_since(self._frame_at)
        self._frame_at = now
        if self._complete:
            if changed > end:
                return None
            self.later += 1
        if first is None or last - first > self._view.width or changed < start:
            first, reset = bin_of(start, width), True
        else:
            first = min(first, bin_of(changed, width))
        count = max(last - first + 1, 0)
        shown = self.shown
        longest, samples, ends = [longest_step(field) for field in shown], [], {}
        for field, step in zip(shown, longest):
            # Slightly more than the bins, whose edges are rounded differently.
            begin = (first - 0.5) * width - (step if math.isfinite(step) else 0.0)
            samples.append(read(field, begin, (last + 1.5) * width))
            if self.stepped(field):
                ends[field] = as_json(lasts(*samples[-1], first, count, width))
        traces, places, counts = {}, {}, {}
        if samples:
            found = all_bins(samples, first, count, width, longest)
            traces = {field: as_json(row) for field, row in zip(shown, found.extremes)}
            placed = zip(shown, found.places.tolist(), (found.places >= 0).any(axis=1).tolist())
            places = {field: row for field, row, has_places in placed if has_places}
            dense = (found.counts > FEW).any(axis=1).nonzero()[0].tolist()
            counts = {shown[row]: found.counts[row].tolist() for row in dense}
        self._open = max(last, first)
        self._complete = self._view.end is not None and now > end + LATE_S
        return {
            "type": "frame",
            "now": now,
            "bin": width,
            "reset": reset,
            "first": first,
            "traces": traces,
            **({"places": places} if places else {}),
            **({"counts": counts} if counts else {}),
            **({"lasts": ends} if ends else {}),
        }


def default_view(window: float) -> View:
    """Return the view of a page that has not requested one.

    :param window: time span [s]
    """
    return View(window, 1000, None)


def pinned(views: Iterable[LiveView]) -> Dict[str, Tuple[float, float]]:
    """Return the spans of paused pages: start and end by name of the field [s]."""
    spans: Dict[str, Tuple[float, float]] = {}
    for view in views:
        if view.pinned is not None:
            start, end = view.pinned
            for name in view.fields:
                before = spans.get(name, (start, end))
                spans[name] = (min(start, before[0]), max(end, before[1]))
    return spans
