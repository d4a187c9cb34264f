"""Loader of overlaid bags, and their shifts by pages."""

import math
import threading
from pathlib import Path
from typing import Any, Callable, Dict, List, Sequence

import numpy
import pytest
from bags import write_bag
from std_msgs.msg import Float64

from nodekit.testing.waiting import wait_until
from topic_scope.bag.overlay import BagOverlay
from topic_scope.page.open_page import Page
from topic_scope.page.trigger import TriggerWatch
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.overlay_request import OverlayRequest
from topic_scope.protocol.requests import Trigger
from topic_scope.protocol.scaling import Scaling, TraceScale
from topic_scope.web.overlay_loader import OverlayLoader


class Bench:
    """Bag with a triangle that rises for 1 s and falls for 1 s, and a page.

    :param missing: numbers of the missing messages, of 21
    """

    def __init__(self, path: Path, missing: Sequence[int] = ()) -> None:
        there = [index for index in range(21) if index not in missing]
        values = {index: 0.1 * min(index, 20 - index) for index in there}
        messages = [("/x", Float64(one), index * 10**8) for index, one in values.items()]
        self.bag = BagOverlay(write_bag(path / "old.bag", messages), "old")
        self.changes = 0
        self.page = Page(5.0)
        self._done = threading.Event()
        self._work: List[Callable[[], None]] = []
        self.overlays = OverlayLoader([self.bag], self._deliver, self._on_change)

    def _deliver(self, work: Callable[[], None]) -> None:
        self._work.append(work)
        self._done.set()

    def _on_change(self) -> None:
        self.changes += 1

    def finish(self) -> None:
        """Deliver the results of reading the bag."""
        assert self._done.wait(30.0)
        self._done.clear()
        self._work.pop()()

    def trigger(self, **changes: Any) -> None:
        wanted = Trigger("normal", "/x/data", 0.5, True)._replace(**changes)
        self.page.trigger = TriggerWatch(wanted, 0.0)

    def errors(self) -> List[str]:
        return [one["text"] for one in self.page.pop_messages() if one["type"] == "error"]

    def bag_state(self) -> Dict[str, Any]:
        (bag,) = self.overlays.message()["bags"]
        return dict(bag)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def test_requested_traces_are_read_in_a_worker_and_reported(bench: Bench) -> None:
    trace = bench.bag.trace("/old/x", ("data",), "", "")
    bench.overlays.read_wanted()
    assert trace.problem == "the bag is being read" and trace.longest_step == math.inf
    later = bench.bag.trace("/old/x", ("data",), "received", "")
    bench.overlays.read_wanted()  # after the current job
    bench.finish()
    assert trace.problem is None and len(trace.ring) == 21 and bench.changes == 1
    assert trace.longest_step == pytest.approx(0.5)
    bench.finish()
    assert later.problem is None and bench.changes == 2
    later.fill(numpy.array([0.0]), numpy.array([1.0]), "stamps 2.00 s behind")
    assert later.correction == "stamps 2.00 s behind"


def test_bag_damaged_meanwhile_is_reported_in_its_row(bench: Bench) -> None:
    trace = bench.bag.trace("/old/x", ("data",), "", "")
    Path(bench.bag.path).unlink()
    bench.overlays.read_wanted()
    bench.finish()
    assert "old.bag: No such file" in str(trace.problem) and bench.changes == 1


def test_bag_is_shifted_by_offset_and_begin(bench: Bench) -> None:
    bench.overlays.begin_at(100.0)
    bag_state = bench.bag_state()
    assert (bag_state["name"], bag_state["file"], bag_state["length"]) == ("old", "old.bag", 2.0)
    bench.overlays.lay(bench.page, OverlayRequest("old", offset=-1.5))
    bench.overlays.lay(bench.page, OverlayRequest("old", begin=200.0))
    bag_state = bench.bag_state()
    assert (bag_state["begin"], bag_state["offset"], bench.bag.place) == (200.0, -1.5, 198.5)
    assert bench.changes == 2


@pytest.mark.parametrize(
    "changes, scale, crossing",
    [
        ({}, TraceScale(), 0.5),
        ({"rising": False}, TraceScale(), 1.5),
        ({"field": "/old/x/data", "level": 0.25}, TraceScale(), 0.25),
        ({"field": "=/x/data*2"}, TraceScale(), 0.25),
        ({}, TraceScale(gain=0.5, offset=0.25), 0.5),
        ({"level": 0.0, "hysteresis": 0.5}, TraceScale(offset=-0.6), 0.6),
        ({"level": 0.25}, TraceScale(steps=True), 0.3),
    ],
)
def test_bag_is_aligned_at_its_first_crossing(
    bench: Bench, changes: Any, scale: TraceScale, crossing: float
) -> None:
    bench.trigger(**changes)
    bench.page.scaling = Scaling({"/x/data": scale})
    bench.bag.offset = 2.0  # it stays, from the aligned position
    bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    bench.finish()
    assert bench.errors() == [] and bench.changes == 2
    assert (bench.bag.begin + crossing, bench.bag.offset) == (pytest.approx(300.0), 2.0)


@pytest.mark.parametrize("field", ["/x/data", "=/x/data * 1"])
def test_after_a_gap_the_bag_is_aligned_where_the_line_continues(
    tmp_path: Path, field: str
) -> None:
    bench = Bench(tmp_path, range(3, 10))
    bench.trigger(field=field)
    bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    bench.finish()
    assert bench.bag.place + 1.0 == pytest.approx(300.0)


def test_bag_is_aligned_while_its_traces_are_read(bench: Bench) -> None:
    trace = bench.bag.trace("/old/x", ("data",), "", "")
    bench.trigger()
    bench.overlays.read_wanted()
    bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    wait_until(lambda: len(bench._work) == 2, lambda: "the bag is not read twice")
    for work in bench._work:
        work()
    assert trace.problem is None and bench.bag.begin == pytest.approx(299.5)


def test_failed_alignment_is_reported_by_name(bench: Bench) -> None:
    with pytest.raises(RequestError, match="no bag new; there are old"):
        bench.overlays.lay(bench.page, OverlayRequest("new", offset=1.0))
    with pytest.raises(RequestError, match="no trigger"):
        bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    bench.trigger(level=7.0)
    bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    with pytest.raises(RequestError, match="aligned already"):
        bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    bench.finish()
    assert bench.errors() == ["old: /x/data never rises through 7"]
    bench.trigger(field="/y/data")
    bench.overlays.lay(bench.page, OverlayRequest("old", trigger=300.0))
    bench.finish()
    (error,) = bench.errors()
    assert "no such topic" in error and "/x/data" in error
    assert bench.bag.place == 0.0
    none = OverlayLoader([], lambda work: work(), lambda: None)
    with pytest.raises(RequestError, match="--over"):
        none.lay(bench.page, OverlayRequest("old", offset=1.0))
