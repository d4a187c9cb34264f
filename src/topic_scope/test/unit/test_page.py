"""Queue of a page: bounded, in order, and consistent."""

import math
from typing import Any, Dict, Tuple

import numpy
import pytest
from test_differences import TimedSource, recording

from topic_scope.masks.mask_check import Mask, MaskCheck
from topic_scope.page import charts
from topic_scope.page.open_page import Page
from topic_scope.page.trigger import TriggerWatch
from topic_scope.page.view import LATE_S, LiveView, pinned
from topic_scope.protocol.requests import Chart, Measure, Trigger, View
from topic_scope.protocol.scaling import Scaling, TraceScale


def test_newer_message_replaces_an_unread_one() -> None:
    page = Page(10.0)
    for index in range(1000):
        page.put({"type": "value", "value": index}, "/node", "a")
        page.put({"type": "value", "value": -index}, "/node", "b")
        page.put({"type": "stats", "index": index})
    assert page.pop_messages() == [
        {"type": "value", "value": 999},
        {"type": "value", "value": -999},
        {"type": "stats", "index": 999},
    ]
    assert page.pop_messages() == []
    for kind in ("selected", "hello", "selected"):  # in the order of the newest of each
        page.put({"type": kind})
    assert [message["type"] for message in page.pop_messages()] == ["hello", "selected"]


def test_one_time_messages_come_first_and_are_limited() -> None:
    page = Page(10.0)
    page.put({"type": "value"})
    for index in range(1000):
        page.put_once({"type": "error", "text": str(index)})
    messages = page.pop_messages()
    assert messages[-1] == {"type": "value"}
    assert [message["text"] for message in messages[:-1]] == [str(n) for n in range(950, 1000)]


def test_page_with_slow_frames_gets_fewer() -> None:
    page = Page(10.0)
    assert page.is_due(0.0)
    page.took(100.0, 100.5)
    assert not page.is_due(101.8)
    assert page.is_due(101.9)


def test_one_long_frame_delays_no_other() -> None:
    page = Page(10.0)
    page.took(100.0, 100.02)
    assert page.is_due(100.025)


def test_long_frames_get_no_more_than_their_share() -> None:
    page, now, worked = Page(10.0), 100.0, 0.0
    while now < 110.0:
        now += 0.025
        if page.is_due(now):
            page.took(now, now + 0.02)
            worked += 0.02
    assert 2.4 < worked < 2.6


def test_statistics_over_time_restart_after_changes() -> None:
    names = ("/a/data", "/b/data")
    source, page = TimedSource(), Page(1.0)
    made = recording(source, *names)
    page.view.select(names)
    page.set_measure(Measure(shapes=True, over_time=1))

    def counts() -> Tuple[int, int]:
        """Measure for one more second; return how often the maximum of each was counted."""
        times = [source.time + 0.01 * index for index in range(100)]
        for name in ("/a", "/b"):
            source.receive(name, times, [math.sin(20.0 * time) for time in times])
        source.time += 1.0
        now = made.update()
        reply = page.frame(made, now, True)
        traces: Dict[str, Any] = next(one for one in reply if one["type"] == "stats")["traces"]
        first, second = (traces[name]["over_time"]["max"]["count"] for name in names)
        return first, second

    assert [counts() for _ in range(3)] == [(1, 1), (2, 2), (3, 3)]
    page.scale(Scaling({"/a/data": TraceScale(1000.0)}))
    assert counts() == (1, 4)
    page.scale(Scaling({"/a/data": TraceScale(1000.0, steps=True), "/b/data": TraceScale()}))
    assert counts() == (2, 5)
    page.set_measure(Measure(shapes=True, over_time=1, against="/a/data"))
    assert counts() == (1, 1)
    page.set_measure(Measure(shapes=True, over_time=1, latency=True, against="/a/data"))
    assert counts() == (2, 2)
    page.scale(Scaling({"/a/data": TraceScale(-1000.0)}))
    assert counts() == (1, 1)


def test_paused_page_keeps_plot_and_figures_consistent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A formula that looks 5 s ahead is complete 5 s after the pause, and is kept."""
    monkeypatch.setattr(charts, "CHART_S", 0.0)
    name = "=highest(/a/data, 5)"
    shown: Dict[int, float] = {}
    reply: Dict[str, Dict[str, Any]] = {}
    source, page = TimedSource(), Page(2.0)
    made = recording(source, name)
    page.view.select([name, "/a/data"])
    page.set_chart(Chart("xy", "/a/data"))
    for index in range(100):
        source.receive("/a", [source.time], [float(index)])
        if index == 20:
            page.view.show(View(4.0, 4, source.time))
        now = made.update()
        made.pin(pinned([page.view]))
        reply.update((message["type"], message) for message in page.frame(made, now, True))
        frame = reply.pop("frame", None)
        if frame is not None:
            shown = {} if frame["reset"] else shown
            bins = frame["traces"][name][::2]
            shown.update((frame["first"] + place, value) for place, value in enumerate(bins))
        source.time += 1.0
    # From 1016 s to 1020 s: for each sample the maximum up to 5 s after it.
    highest = [21.0, 22.0, 23.0, 24.0, 25.0]
    figures = reply["stats"]["traces"][name]
    assert (figures["min"], figures["max"]) == (highest[0], highest[-1])
    assert [shown[1016 + second] for second in range(5)] == highest
    assert reply["xy"]["traces"] == {name: [[16.0, 17.0, 18.0, 19.0, 20.0], highest]}


def test_samples_of_all_paused_pages_are_kept() -> None:
    views = [LiveView(View(5.0, 100, 1000.0)), LiveView(View(2.0, 100, 1001.0))]
    for view in views:
        view.select(["/a/data"])
    for order in (views, views[::-1]):
        assert pinned(order) == {"/a/data": (995.0, 1001.0 + LATE_S)}


def test_paused_page_keeps_what_it_has_shown_until_it_moves_on() -> None:
    view = LiveView(View(5.0, 100, 1000.0))
    view.show(View(2.0, 100, 990.0))
    assert view.pinned == (988.0, 1000.0 + LATE_S)
    view.show(View(2.0, 100, None))
    assert view.pinned is None


def test_jump_of_the_clock_restarts_trigger_and_mask() -> None:
    page = Page(5.0)
    page.trigger = trigger = TriggerWatch(Trigger("single", "/a/data", 0.0, True, 7), 0.0)
    page.mask = mask = MaskCheck(Mask("/a/data", "/b/data", 1.0, 0.0), 0.0)
    page.restart(1000.0)
    assert page.trigger is not trigger and page.trigger.request == trigger.request
    assert page.mask is not mask and page.mask.mask == mask.mask


def test_changed_samples_are_sent_again_at_once() -> None:
    source, page = TimedSource(), Page(5.0)
    made = recording(source, "/a/data", "/b/data")
    page.view.select(["/a/data"])
    page.set_chart(Chart("xy", "/b/data"))
    for name in ("/a", "/b"):
        source.receive(name, [source.time, source.time + 0.1], [1.0, 2.0])
    source.time += 1.0
    now = made.update()
    for change in (lambda: None, lambda: page.scale(Scaling({"/a/data": TraceScale(steps=True)}))):
        change()
        reply = {one["type"]: one for one in page.frame(made, now, False)}
        assert reply["frame"]["reset"] and reply["xy"]["traces"] == {"/a/data": [[1, 2], [1, 2]]}
    assert list(reply["frame"]["lasts"]) == ["/a/data"]  # drawn in steps


def test_chart_interpolates_its_slow_horizontal_trace_and_follows_the_selection(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(charts, "CHART_S", 0.0)
    times = {"/x": numpy.arange(1000.0, 1011.0), "/y": numpy.arange(1000.0, 1010.0, 0.25)}
    times["/z"] = times["/y"]
    view = LiveView(View(10.0, 100, 1010.0))
    view.select(["/y"])
    feed = charts.ChartFeed(Chart("xy", "/x"))

    def update(now: float = 1010.0) -> Any:
        return feed.update(
            now,
            lambda name, *_: (times[name], times[name] - 1000.0),
            {"/x": 5.0, "/y": 0.5, "/z": 0.5}.__getitem__,
            view,
        )

    assert update()["traces"]["/y"][0] == [0.25 * index for index in range(40)]
    assert update() is None
    view.select(["/y", "/z"])
    assert list(update()["traces"]) == ["/y", "/z"]
    assert update(1010.0 + LATE_S) is None
    assert update(1010.0 + LATE_S + 0.1) is not None  # with the late samples of its span
