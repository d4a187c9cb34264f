"""What waits for a page stays bounded, and is in the right order; what it is told agrees."""

import math
from typing import Any, Dict, Tuple

from test_differences import TimedSource, recording

from topic_scope.page.page import Page
from topic_scope.protocol.requests import Measure
from topic_scope.protocol.scaling import Scaling, TraceScale


def test_news_replaces_what_was_not_read() -> None:
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


def test_what_is_said_once_comes_first_and_is_limited() -> None:
    page = Page(10.0)
    page.put({"type": "value"})
    for index in range(1000):
        page.put_once({"type": "error", "text": str(index)})
    messages = page.pop_messages()
    assert messages[-1] == {"type": "value"}
    assert [message["text"] for message in messages[:-1]] == [str(n) for n in range(950, 1000)]


def test_a_page_whose_frames_take_long_gets_them_less_often() -> None:
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


def test_figures_over_time_begin_anew_where_they_would_mix_what_differs() -> None:
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
        told = page.frame(made, now, True)
        traces: Dict[str, Any] = next(one for one in told if one["type"] == "stats")["traces"]
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
