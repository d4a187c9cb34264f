"""Topics of one clock, and contradicted stamps, as shown to users."""

import asyncio
import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy
import pytest
from bags import BEGIN, serialized, write_bag
from geometry_msgs.msg import PointStamped
from rospy import Duration, Time
from test_recorder import FakeSource, FakeSubscription, header

from topic_scope.analysis.waveform import phase
from topic_scope.bag.player import BagPlayer
from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.ros1_recording import Ros1Recording
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.csv_export import parts
from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.statistics_table import statistics_of
from topic_scope.page.view import LiveView
from topic_scope.protocol.requests import Measure, View
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder
from topic_scope.sampling.traces import Trace
from topic_scope.timing.nanoseconds import NS

MS = NS // 1000
#: Start of recording [ns]; and the lag of an old bag, and of a simulation.
NOW = 1_700_000_000 * NS
OLD, SIMULATION = 40_000_000 * NS, NOW - 12 * NS
TOPICS = {"/a": "geometry_msgs/PointStamped", "/b": "geometry_msgs/PointStamped"}


def stamped(time: int, value: float) -> PointStamped:
    """Return a message with a stamp [ns]."""
    message = PointStamped()
    message.header.stamp = Time(*divmod(time, NS))
    message.point.x = value
    return message


def sine(seconds: float) -> float:
    """Return a sine of 1 Hz."""
    return math.sin(2.0 * math.pi * seconds)


def received(
    messages: Dict[str, Sequence[Tuple[int, PointStamped]]],
    *names: str,
    watch: Callable[[Recorder], object] = lambda _made: None,
) -> Recorder:
    """Return a recorder that has received messages, 40 times a second.

    :param messages: messages with their times of receipt [ns], by topic
    :param watch: called after each update
    """
    source = FakeSource()
    source.time = NOW / NS
    source.topics = {topic: FakeSubscription() for topic in messages}
    made = Recorder(source, Layouts(), 60.0)  # type: ignore[arg-type]
    made.set_topics(TOPICS)
    made.want(names, source.time)
    last = max(when for sent in messages.values() for when, _ in sent)
    begin = NOW
    while begin <= last:
        end = begin + 25 * MS
        for topic, sent in messages.items():
            some = [one for one in sent if begin <= one[0] < end]
            if some:
                times, data = [when for when, _ in some], [serialized(one) for _, one in some]
                source.topics[topic].batches.append(Batch(header(PointStamped), times, data))
        source.time = end / NS
        made.update()
        watch(made)
        begin = end
    source.time += 2.0
    made.update()
    watch(made)
    return made


@pytest.mark.parametrize("name", ["/{}/point/x", "/{}/point/x@stamp"], ids=["chosen", "named"])
@pytest.mark.parametrize("behind", [OLD, SIMULATION], ids=["old bag", "simulation"])
@pytest.mark.parametrize(
    "speed",
    [
        0.1,
        pytest.param(1.0, marks=pytest.mark.extended),
        pytest.param(10.0, marks=pytest.mark.extended),
    ],
)
def test_equal_sines_of_one_clock_are_in_phase_though_one_is_delivered_late(
    name: str, behind: int, speed: float
) -> None:
    span = 20.0 * min(speed, 2.0)
    seconds = numpy.arange(0.0, span, 0.01)
    begin = NOW - behind
    sent: Dict[str, List[Tuple[int, PointStamped]]] = {}
    for topic, delay in (("/a", 0.0), ("/b", 0.1)):
        sent[topic] = [
            (NOW + round((one + delay) / speed * NS), stamped(begin + round(one * NS), sine(one)))
            for one in seconds.tolist()
        ]
    first, second = name.format("a"), name.format("b")
    made = received(sent, first, second, f"{first}-{second}")
    one, other = (made.samples(field, -math.inf, math.inf) for field in (first, second))
    turned = phase(one, other, math.inf)
    assert turned.value == pytest.approx(0.0, abs=0.01)
    _, apart = made.samples(f"{first}-{second}", -math.inf, math.inf)
    apart = apart[numpy.isfinite(apart)]
    assert len(apart) > len(seconds) // 2 and numpy.abs(apart).max() < 1e-9


def csv_rows(made: Recorder, name: str) -> numpy.ndarray:
    """Return time and value of the rows of the page's CSV, sorted by value."""

    async def text() -> str:
        return "".join([part async for part in parts(made, [name], 0.0, 1e10)])

    lines = asyncio.run(text()).splitlines()[1:]
    found = [line.split(",") for line in lines]
    return numpy.array(sorted((float(row[2]), float(row[0])) for row in found if row[2] != "nan"))


@pytest.mark.parametrize("late", [0.6, pytest.param(20.0, marks=pytest.mark.extended)])
def test_late_message_does_not_move_other_csv_rows(late: float) -> None:
    stamps = [NOW + 20 * MS * index for index in range(1500)]
    sent = [(when, stamped(when, index)) for index, when in enumerate(stamps)]
    sent[1200][1].header.stamp -= Duration.from_sec(late)
    made = received({"/a": sent, "/b": sent}, "/a/point/x")
    rows = csv_rows(made, "/a/point/x")
    expected = numpy.array(stamps) / NS
    expected[1200] -= late
    assert rows[:, 1] == pytest.approx(expected, abs=1e-6)
    trace = made.trace("/a/point/x")
    assert trace is not None
    assert trace.stream.correction == f"1 stamp up to {late:.2f} s late"


def test_last_message_is_sent_to_pages_though_it_is_late() -> None:
    stamps = [NOW + 20 * MS * index for index in range(100)]
    sent = [(when, stamped(when, index)) for index, when in enumerate(stamps)]
    sent[-1][1].header.stamp -= Duration.from_sec(0.6)
    seen, changes = [0.0], []

    def look(made: Recorder) -> None:
        changes.append(made.changed_since(seen[-1]))
        seen.append(made.updated)

    received({"/a": sent, "/b": []}, "/a/point/x", watch=look)
    assert changes[-1] == pytest.approx(stamps[-1] / NS - 0.6, abs=1e-6)


@pytest.mark.parametrize("ahead", [600.0, 300.0, 30.0])
@pytest.mark.parametrize("name", ["/a/point/x", "/a/point/x@stamp"], ids=["chosen", "named"])
def test_stamp_far_ahead_displaces_no_samples(ahead: float, name: str) -> None:
    stamps = [NOW + 20 * MS * index for index in range(500)]
    sent = [(when, stamped(when, index)) for index, when in enumerate(stamps)]
    sent[100][1].header.stamp += Duration.from_sec(ahead)
    made = received({"/a": sent, "/b": sent}, name)
    rows = csv_rows(made, name)
    assert rows[:, 1] == pytest.approx(numpy.array(stamps) / NS, abs=1e-6)
    trace = made.trace(name)
    assert trace is not None and trace.silence(stamps[-1] / NS) == pytest.approx(0.0, abs=1e-6)
    text = f"1 stamp up to {ahead:g} s ahead: shown at reception"
    assert trace.stream.correction == text


@pytest.mark.parametrize(
    "behind, reason",
    [
        (0, None),
        (SIMULATION, "the stamps are of another clock: no latency"),
        (-8000 * NS, "the stamps are of another clock: no latency"),
    ],
    ids=["machine", "simulation", "ahead"],
)
def test_stamps_of_another_clock_have_no_latency(behind: int, reason: Optional[str]) -> None:
    whens = [NOW + 20 * MS * index for index in range(200)]
    sent = [(when, stamped(when - 5 * MS - behind, 1.0)) for when in whens]
    trace = received({"/a": sent, "/b": sent}, "/a/point/x").trace("/a/point/x")
    assert isinstance(trace, Trace) and trace.stream.no_latency == reason
    assert set(trace.latency(0.0, 1e10).round(6)) == (set() if reason else {0.005})


def test_table_has_latencies_or_the_reason_why_not() -> None:
    whens = [NOW + 20 * MS * index for index in range(200)]
    sent = {
        "/a": [
            (when, stamped(when - (5 + 10 * (n == 150)) * MS, 1.0)) for n, when in enumerate(whens)
        ],
        "/b": [(when, stamped(when - SIMULATION, 1.0)) for when in whens],
    }
    made, view = received(sent, *TOPIC_FIELDS), LiveView(View(20.0, 100, None))
    view.select(TOPIC_FIELDS)
    wanted, backoff = Measure(latency=True, shapes=True), FrequencyBackoff()
    table = statistics_of(made, made.samples, view, wanted, backoff, made.updated)["traces"]
    one, other = (table[name] for name in TOPIC_FIELDS)
    assert one["latency"] == pytest.approx(0.005, abs=1e-6)
    assert one["latency_max"] == pytest.approx(0.015, abs=1e-6)
    assert other["unmeasurable"]["latency"] == "the stamps are of another clock: no latency"
    assert one["frequency"] is None and "frequency" not in one["uncertainty"]


def test_csv_begins_at_its_start() -> None:
    sent = [(NOW, stamped(NOW, 1.0)), (NOW + MS, stamped(NOW + MS, 2.0))]
    made = received({"/a": sent, "/b": sent}, "/a/point/x")

    async def text() -> str:
        start = (NOW + 500) / NS
        return "".join([part async for part in parts(made, ["/a/point/x"], start, 1e10)])

    assert [line.split(",")[2] for line in asyncio.run(text()).splitlines()[1:]] == ["2.0"]


def test_the_csv_has_all_digits_of_stamps_and_receptions() -> None:
    sent = [(NOW + 123_456_789, stamped(NOW + 987_654, 1.5))]
    made = received({"/a": sent, "/b": sent}, "/a/point/x")

    async def text() -> str:
        return "".join([part async for part in parts(made, ["/a/point/x"], 0.0, 1e10)])

    (line,) = asyncio.run(text()).splitlines()[1:]
    assert line == "1700000000.000987654,1700000000.123456789,1.5"


def test_a_mean_is_of_as_many_samples_everywhere() -> None:
    """0.1 s at 100 Hz has ten samples, without the sample at the start of the window."""
    stamps = [NOW + 10 * MS * index for index in range(1000)]
    sent = [(when, stamped(when, float(index))) for index, when in enumerate(stamps)]
    made = received({"/a": sent, "/b": sent}, "=mean(/a/point/x, 0.1)")
    _, means = made.samples("=mean(/a/point/x, 0.1)", -math.inf, math.inf)
    assert means[9:] == pytest.approx(numpy.arange(9, 1000) - 4.5, abs=1e-9)


def test_the_second_derivative_of_a_ramp_at_1_khz_is_zero() -> None:
    stamps = [NOW + MS * index for index in range(3000)]
    sent = [(when, stamped(when, 0.01 * index)) for index, when in enumerate(stamps)]
    twice = "=derivative(derivative(/a/point/x))"
    made = received({"/a": sent, "/b": sent}, twice, "/a/point/x.derivative")
    _, bends = made.samples(twice, -math.inf, math.inf)
    assert len(bends) == 2998 and numpy.abs(bends).max() < 1e-6
    _, slopes = made.samples("/a/point/x.derivative", -math.inf, math.inf)
    assert slopes == pytest.approx(10.0, abs=1e-9)


def in_bag(path: Path, sent: Dict[str, List[Tuple[int, PointStamped]]], *names: str) -> List[Any]:
    """Return the series that plot_bag draws."""
    messages = [(topic, one, when) for topic, some in sent.items() for when, one in some]
    name = write_bag(path / "x.bag", sorted(messages, key=lambda one: one[2]))
    with Ros1Recording(name) as bag:
        lines, readers = chosen(bag, first_messages(bag), names)
        return series_of(bag, lines, readers, slices(bag, sorted(sent)))


@pytest.mark.parametrize("name", ["/{}/point/x", "/{}/point/x@stamp"], ids=["chosen", "named"])
def test_plot_bag_moves_topics_of_one_clock_together(tmp_path: Path, name: str) -> None:
    sent = {
        topic: [
            (10 * MS * index + delay, stamped(12 * NS + 10 * MS * index, float(index)))
            for index in range(1000)
        ]
        for topic, delay in (("/a", 0), ("/b", 100 * MS))
    }
    first, second = in_bag(tmp_path, sent, name.format("a"), name.format("b"))
    assert list(first.times) == list(second.times)
    assert first.times[0] == pytest.approx(0.0, abs=1e-3)
    assert first.correction == "stamps of another clock: shown at reception"


def test_plot_bag_names_the_stamps_that_others_contradict(tmp_path: Path) -> None:
    sent = {"/a": [(10 * MS * n, stamped(BEGIN + 10 * MS * n, float(n))) for n in range(1000)]}
    sent["/a"][300][1].header.stamp -= Duration(5)
    sent["/a"][600][1].header.stamp += Duration(600)
    (series,) = in_bag(tmp_path, sent, "/a/point/x")
    expected = [0.01 * index for index in range(1000)]
    expected[300] -= 5.0
    times = numpy.array(series.times)[numpy.isfinite(series.values)]  # a line ends at a gap
    assert sorted(times) == pytest.approx(sorted(expected), abs=1e-6)
    assert series.correction == (
        "1 stamp up to 5.00 s late; 1 stamp up to 600 s ahead: shown at reception"
    )


def test_early_stamp_does_not_expire_other_samples() -> None:
    stamps = [NOW + 100 * MS * index for index in range(585)]  # 58.4 s, of which 60 s are kept
    sent = [(when, stamped(when, index)) for index, when in enumerate(stamps)]
    sent[-10][1].header.stamp += Duration(9)
    made = received({"/a": sent, "/b": sent}, "/a/point/x")
    assert len(csv_rows(made, "/a/point/x")) == 585


def test_set_clock_shifts_all_of_its_topics() -> None:
    """The topic without newer messages is shifted with the clock as well."""
    sent: Dict[str, List[Tuple[int, PointStamped]]] = {"/a": [], "/b": []}
    for index in range(600):
        when = NOW + 10 * MS * index
        pause = 1500 * MS if index >= 300 else 0  # as of a paused simulation
        for topic in ("/a", "/b") if index < 300 else ("/a",):
            sent[topic].append((when + pause, stamped(when - SIMULATION, float(index))))
    changes: List[float] = []

    def look(made: Recorder) -> None:
        changes.append(made.changed_since(made.updated - 0.02))

    made = received(sent, "/a/point/x", "/b/point/x", watch=look)
    moved = [index for index, since in enumerate(changes) if since == -math.inf]
    assert any(index > 170 for index in moved)
    one, other = (made.samples(name, -math.inf, math.inf)[0] for name in TOPIC_FIELDS)
    assert other == pytest.approx(one[: len(other)], abs=1e-6)


TOPIC_FIELDS = ("/a/point/x", "/b/point/x")


def test_last_message_of_a_bag_does_not_wait(tmp_path: Path) -> None:
    """The last message is 5 s late, and no other will confirm it."""
    stamps = [BEGIN + 10 * MS * index for index in range(800)]
    sent = [("/a", stamped(when, float(n)), when - BEGIN) for n, when in enumerate(stamps)]
    sent[-1][1].header.stamp -= Duration(5)
    player = BagPlayer(Ros1Recording(write_bag(tmp_path / "x.bag", sent)), 60.0, lambda: 0.0)
    made = Recorder(player, Layouts(), 60.0)
    made.set_topics(TOPICS)
    made.want(["/a/point/x"], player.start)
    player.seek(player.end)
    made.update()
    times, values = made.samples("/a/point/x", player.start, player.end)
    assert sorted(values[numpy.isfinite(values)]) == [float(index) for index in range(800)]
