"""Overlaid bag, and its shifts."""

import math
from pathlib import Path
from typing import Any, List
from unittest import mock

import numpy
import pytest
from bags import BEGIN, write_bag
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from topic_scope.bag.recording import BagError
from topic_scope.bag.overlay import BagOverlay
from topic_scope.messages.layout_cache import Layouts
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, to_ns

NOW = 5000.0


def rising(count: int) -> List[Any]:
    """Return messages with increasing numbers, ten per second."""
    return [("/x", Float64(float(index)), index * 10**8) for index in range(count)]


@pytest.fixture
def overlay(tmp_path: Path) -> BagOverlay:
    late = PointStamped()
    late.header.stamp.secs, late.header.stamp.nsecs = divmod(BEGIN, 10**9)
    messages = rising(31) + [
        ("/late", late, 8 * 10**8),
        ("/a", Float64MultiArray(data=[1.0]), 0),
        ("/a", Float64MultiArray(data=[1.0, 2.0]), 10**9),
        ("/j", JointState(name=["arm", "leg"], position=[0.1, 0.2]), 10**9),
    ]
    made = BagOverlay(write_bag(tmp_path / "old.bag", messages), "old", 0.5)
    made.begin = 1000.0
    return made


def recording(overlay: BagOverlay, *names: str) -> Recorder:
    """Return a recorder with an overlaid bag whose requested traces have been read."""
    source = mock.Mock(**{"clock.now.return_value": NOW, "subscriptions.return_value": {}})
    made = Recorder(source, Layouts(), 10.0, [overlay])
    made.set_topics({"/live": "std_msgs/Float64", **overlay.types})
    made.want(names, NOW)
    wanted = overlay.take_wanted()
    for (_, trace), one in zip(wanted, overlay.read([name for name, _ in wanted])):
        trace.fill(one.times, one.values, one.correction)
    return made


def test_overlay_topics_have_its_name_as_prefix(overlay: BagOverlay) -> None:
    made = recording(overlay)
    listed = [choice.field for choice in made.choices()]
    assert "/live/data" in listed and "/old/x/data" in listed
    assert made.expand("/old/late/point") == [f"/old/late/point/{axis}" for axis in "xyz"]
    assert made.expand("/old/j/position[0]") == ["/old/j/position[0]"]
    assert "/old/j/position[leg]" in listed


def test_overlay_is_shifted_with_all_of_its_samples(
    overlay: BagOverlay,
) -> None:
    made = recording(overlay, "/old/x/data")
    times, values = made.samples("/old/x/data", 0.0, 1e9)
    assert values.tolist() == [float(index) for index in range(31)]
    assert times.tolist() == pytest.approx([1000.5 + 0.1 * index for index in range(31)])
    overlay.offset = -0.25
    times, values = made.samples("/old/x/data", 1000.0, 1000.3)
    assert (values.tolist(), times[0]) == ([3.0, 4.0, 5.0], pytest.approx(1000.05))


def test_overlay_works_in_formulas_and_moves_in_a_paused_view(overlay: BagOverlay) -> None:
    name = "=/old/x/data + 1"
    made = recording(overlay, name)
    made.pin({name: (1000.0, 1004.0)})
    overlay.begin = 2000.0
    times, values = made.samples(name, 0.0, 1e9)
    assert times[0] == pytest.approx(2000.5) and values[0] == 1.0
    assert made.trace(name).silence(NOW) == 0.0  # type: ignore[union-attr]


def test_selected_stamp_uses_the_clock_of_the_bag(overlay: BagOverlay) -> None:
    made = recording(overlay, "/old/late/point/x@stamp", "/old/late/point/x@received")
    (stamped,), _ = made.samples("/old/late/point/x@stamp", 0.0, 1e9)
    (received,), _ = made.samples("/old/late/point/x@received", 0.0, 1e9)
    assert (stamped, received) == (pytest.approx(1000.5), pytest.approx(1001.3))
    trace = made.trace("/old/late/point/x@stamp")
    assert trace is not None and trace.stream.timestamp == "stamp"
    assert len(trace.latency(0.0, 1e9)) == 0
    assert (trace.rows(0, to_ns(1e9))[2] / NS).tolist() == [stamped]


def test_overlay_samples_survive_a_reset(overlay: BagOverlay) -> None:
    made = recording(overlay, "/old/x/data", "/live/data")
    made.forget()
    assert len(made.samples("/old/x/data", 0.0, 1e9)[0]) == 31 and not overlay.take_wanted()


def test_missing_field_of_an_overlay_is_reported(overlay: BagOverlay) -> None:
    names = ("/old/x/data", "/old/x/nothing", "/old/a/data[1]", "/old/a/data[7]")
    made = recording(overlay, *names)
    assert made.problem("/old/x/data") is None and made.problem("/old/a/data[1]") is None
    assert made.problem("/old/a/data[7]") == "the bag does not have this number"
    assert "there is no nothing in" in str(made.problem("/old/x/nothing"))
    assert made.problem("/old/y/data") == "the topic does not exist yet"
    waiting = Recorder(mock.Mock(), Layouts(), 10.0, [overlay])
    waiting.set_topics(overlay.types)
    waiting.want(["/old/x/data"], NOW)
    assert waiting.problem("/old/x/data") == "the bag is being read"


def test_overlay_and_live_names_are_found_in_the_bag(overlay: BagOverlay) -> None:
    assert overlay.name_in_bag("/x/data") == overlay.name_in_bag("/old/x/data") == "/x/data"
    assert overlay.name_in_bag("=/old/x/data - 2*/x/data") == "=/x/data - 2 * /x/data"
    assert overlay.name_in_bag("/older/x") == "/older/x"


def test_gaps_end_lines(tmp_path: Path) -> None:
    messages = [message for message in rising(60) if not 30 <= message[1].data < 50]
    overlay = BagOverlay(write_bag(tmp_path / "gap.bag", messages), "old")
    made = recording(overlay, "/old/x/data")
    _, values = made.samples("/old/x/data", 0.0, 1e9)
    assert sum(map(math.isnan, values)) == 1 and made.longest_step("/old/x/data") < 1.0


def test_ends_of_lines_do_not_affect_the_longest_step(tmp_path: Path) -> None:
    times = numpy.cumsum([0, 100, 100, 100, 2000, 200, 200, 2000])
    messages = [("/x", Float64(1.0), int(time) * 10**6) for time in times]
    overlay = BagOverlay(write_bag(tmp_path / "gap.bag", messages), "old")
    (series,) = overlay.read(["/x/data"])
    assert sum(map(math.isnan, series.values)) == 2
    assert overlay.longest_step(series) == pytest.approx(5 * 0.2)


def test_non_bag_file_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "x.bag").write_text("no")
    with pytest.raises(BagError, match="x.bag is not a bag"):
        BagOverlay(str(tmp_path / "x.bag"), "old")
