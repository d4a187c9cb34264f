# Pure: knows no ROS.
"""View of one page: the bins that it has, and those that it needs next."""

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

#: Returns how far apart samples of one line of a field may be [s].
GapLimit = Callable[[str], float]

#: For how long after its end a page that is paused goes on as before, as samples come late [s]; and
#: how often it then looks for those that are later.
LATE_S = 1.0


class LiveView:
    """The frames of one page.

    :param view: the span of time that is shown
    """

    def __init__(self, view: View) -> None:
        self.fields: Sequence[str] = ()
        self._hidden: FrozenSet[str] = frozenset()
        self._view = view
        #: First bin that the page does not have in full; None where it has none.
        self._open: Optional[int] = None
        self._complete = False
        #: How often samples have come when all were thought to be there.
        self.later = 0
        self._frame_at = 0.0
        #: Tells whether the value of a field holds until the next one comes.
        self.stepped: Callable[[str], bool] = lambda _field: False
        #: What was shown since the page stands still, from start to end [s]; None while it moves.
        self.pinned: Optional[Tuple[float, float]] = None
        self._pin()

    def show(self, view: View) -> None:
        """Show another span of time."""
        self._view = view
        self._pin()
        self.restart()

    def select(self, fields: Sequence[str]) -> None:
        """Show other fields."""
        self.fields = fields
        self.restart()

    def hide(self, fields: Collection[str]) -> None:
        """Send nothing of some fields; what was hidden before and is not now is sent in full."""
        if self._hidden.difference(fields) & set(self.fields):
            self.restart()
        self._hidden = frozenset(fields)

    @property
    def shown(self) -> List[str]:
        """The fields of numbers that are not hidden."""
        return [one for one in self.fields if one not in self._hidden and not is_state(one)]

    @property
    def states(self) -> List[str]:
        """The states that are not hidden."""
        return [one for one in self.fields if one not in self._hidden and is_state(one)]

    def restart(self) -> None:
        """Send all that is to be seen with the next frame."""
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
        """Return start and end of what is shown [s]."""
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
        """Return what the page does not have yet.

        :param now: time up to which what was received is there [s]
        :param read: returns samples
        :param changed_since: tells from when on there are others than at an earlier time [s]
        :param longest_step: tells where a line ends
        :returns: the frame, None where nothing has come
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
            # A little more than the bins, whose edges are rounded otherwise.
            begin = (first - 0.5) * width - (step if math.isfinite(step) else 0.0)
            samples.append(read(field, begin, (last + 1.5) * width))
            if self.stepped(field):
                ends[field] = as_json(lasts(*samples[-1], first, count, width))
        traces, places, counts = {}, {}, {}
        if samples:
            found = all_bins(samples, first, count, width, longest)
            traces = {field: as_json(row) for field, row in zip(shown, found.extremes)}
            told = zip(shown, found.places.tolist(), (found.places >= 0).any(axis=1).tolist())
            places = {field: row for field, row, is_told in told if is_told}
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
    """Return what is shown to a page that has not said what it wants.

    :param window: span of time [s]
    """
    return View(window, 1000, None)


def pinned(views: Iterable[LiveView]) -> Dict[str, Tuple[float, float]]:
    """Return what stands still on some pages: begin and end by name of the field [s]."""
    spans: Dict[str, Tuple[float, float]] = {}
    for view in views:
        if view.pinned is not None:
            start, end = view.pinned
            for name in view.fields:
                before = spans.get(name, (start, end))
                spans[name] = (min(start, before[0]), max(end, before[1]))
    return spans
