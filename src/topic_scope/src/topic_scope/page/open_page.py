"""State of one open page: its requests, and the messages queued for it."""

from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

from topic_scope.masks.mask_check import MaskCheck
from topic_scope.page.charts import ChartFeed
from topic_scope.page.state_feed import StateFeed
from topic_scope.page.statistics_table import statistics_of
from topic_scope.page.statistics_history import StatisticsHistory
from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.trigger import TriggerWatch
from topic_scope.page.view import LiveView, default_view
from topic_scope.protocol.requests import Chart, Measure, Trigger
from topic_scope.protocol.scaling import Scaling
from topic_scope.sampling.recorder import Recorder

#: Most responses that are queued for a page that does not read.
_NOTES = 50
#: Largest share of the time for the frames of one page, so that other pages have the rest.
_SHARE = 0.25
#: Time by which a page may exceed it [s]: a single long frame, with statistics, delays no others.
_CREDIT_S = 0.1


class Page:
    """State of one page, without its connection.

    Newer messages replace unread ones, so that a page that does not read costs no memory, and sees
    the present when it reads again.

    :param window: initial time span [s]
    """

    def __init__(self, window: float) -> None:
        #: Names as the page selected them; None until it has selected any.
        self.chosen: Optional[Tuple[str, ...]] = None
        self.wants_graph = False
        #: Topic whose images the page shows; empty for none.
        self.image_topic = ""
        #: Whether its next frame includes statistics.
        self.is_to_measure = False
        self.view = LiveView(default_view(window))
        self.trigger = TriggerWatch(Trigger("off", "", 0.0, True), 0.0)
        self.chart = ChartFeed(Chart())
        self._states = StateFeed()
        self.measure = Measure()
        self._statistics_history = StatisticsHistory()
        self._backoff = FrequencyBackoff()
        self.scaling = Scaling()
        self.mask: Optional[MaskCheck] = None
        self._rests_until = 0.0
        self._latest: Dict[Any, Dict[str, Any]] = {}
        self._notes: Deque[Dict[str, Any]] = deque(maxlen=_NOTES)

    def restart(self, now: float) -> None:
        """Restart view, trigger and mask at another time.

        :param now: the new time [s]
        """
        self.view.restart()
        self._states = StateFeed()
        self.trigger = TriggerWatch(self.trigger.request, now)
        if self.mask is not None:
            self.mask = MaskCheck(self.mask.mask, now)

    def scale(self, scaling: Scaling) -> None:
        """Set the scaling of its traces.

        :param scaling: the new scaling
        """
        changed, self.scaling = scaling.differing(self.scaling), scaling
        if self.measure.against in changed:  # a negative gain inverts the phases of all others
            self._statistics_history = StatisticsHistory()
        self._statistics_history.forget(changed)
        self.view.stepped = scaling.is_stepped
        self.show_again()

    def show_again(self) -> None:
        """Send its traces again: their samples have changed."""
        self.view.restart()
        self.chart = ChartFeed(self.chart.request)
        self._states = StateFeed()

    def set_measure(self, measure: Measure) -> None:
        """Set the measurements; another reference restarts the statistics of phases."""
        if measure.against != self.measure.against:
            self._statistics_history = StatisticsHistory()
        self.measure = measure

    def set_chart(self, chart: Chart) -> None:
        """Set the chart."""
        self.chart = ChartFeed(chart)

    def watch(self, recorder: Recorder, now: float) -> None:
        """Search the samples for the page's trigger.

        :param recorder: recorder of the samples
        :param now: time up to which they are complete [s]
        """

        def longest(field: str) -> float:  # a stepped trace holds its value until the next sample
            return 0.0 if self.scaling.is_stepped(field) else recorder.longest_step(field)

        samples = self.scaling.scaled(recorder.samples)
        crossing = self.trigger.update(now, self.view.window, samples, longest)
        if crossing is not None:
            self.put(crossing)

    def frame(self, recorder: Recorder, now: float, measures: bool) -> List[Dict[str, Any]]:
        """Return the messages to send now, with the new samples of the traces.

        :param recorder: recorder of the samples
        :param now: time up to which they are complete [s]
        :param measures: whether to include statistics
        """
        samples, longest = self.scaling.scaled(recorder.samples), recorder.longest_step
        if measures:
            statistics = statistics_of(
                recorder, samples, self.view, self.measure, self._backoff, now
            )
            span = self.measure.span(now) or self.view.span(now)
            self._statistics_history.count(self.measure.over_time, span, statistics["traces"])
            self.put(statistics)
            if self.mask is not None:
                self.put(_mask_message(self.mask, recorder))
        chart = self.chart.update(now, samples, longest, self.view)
        if chart is not None:
            self.put(chart)
        states = self._states.update(recorder, self.view, now)
        if states is not None:
            self.put(states)
        frame = self.view.frame(now, samples, recorder.changed_since, longest)
        return self.pop_messages() + ([frame] if frame is not None else [])

    def is_due(self, now: float) -> bool:
        """Return whether a frame of this page is due.

        :param now: s on the monotonic clock
        """
        return now >= self._rests_until

    def took(self, start: float, end: float) -> None:
        """Record the duration of the last frame: a page with long frames gets fewer.

        :param start: start of the work, s on the monotonic clock
        :param end: its end [s]
        """
        self._rests_until = max(self._rests_until, start - _CREDIT_S) + (end - start) / _SHARE

    def put(self, message: Dict[str, Any], *key: str) -> None:
        """Send a message; it replaces one of its type and key that has not been sent yet."""
        place = (message["type"],) + key
        self._latest.pop(place, None)  # reinserted at the end: newer than other waiting messages
        self._latest[place] = message

    def put_once(self, message: Dict[str, Any]) -> None:
        """Send a message that is not replaced by later messages."""
        self._notes.append(message)

    def pop_messages(self) -> List[Dict[str, Any]]:
        """Return and clear the messages to send."""
        messages = list(self._notes) + list(self._latest.values())
        self._latest.clear()
        self._notes.clear()
        return messages


def _mask_message(check: MaskCheck, recorder: Recorder) -> Dict[str, Any]:
    """Return the message with the result of a mask check."""
    result = check.update(recorder)
    limits = [check.mask.lower, check.mask.upper]
    text = check.words(recorder)
    return {"type": "mask", "text": text, "limits": limits, **result._asdict()}
