"""Samples are placed at their stamps, however late their messages, in all outputs of the scope."""

import asyncio
import io
import math
import random
from typing import Any, Dict, List, Optional

import numpy
import pytest
from bags import BagMessage, reading, serialized, slices
from geometry_msgs.msg import PointStamped
from rospy import Duration, Time

from topic_scope.analysis.waveform import phase
from topic_scope.bag.columns import Column
from topic_scope.bag.series import collect
from topic_scope.bag.column_reader import write_csv
from topic_scope.messages.message_layout import layout_of
from topic_scope.messages.timestamp_source import correction
from topic_scope.page.csv_export import parts
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.traces import Stream, Trace
from topic_scope.timing.nanoseconds import to_ns

START, PERIOD_S, COUNT, SINE_HZ = 1000.0, 0.01, 600, 1.0
STAMPS = [START + PERIOD_S * index for index in range(COUNT)]
SEED = random.Random(1)
#: Delays of messages [s].
DELAYS: Dict[str, List[float]] = {
    "0": [0.0] * COUNT,
    "0.3": [0.3] * COUNT,
    "0.8": [0.8] * COUNT,
    "0.4 to 0.6": [SEED.uniform(0.4, 0.6) for _ in range(COUNT)],
}
NAME = "/s/point/x@stamp"
#: The same in a bag, relative to its start [ns].
EXACT, BAG_BEGIN = Column("/s", ("point", "x"), "stamp"), round(START * 1e9)

late = pytest.mark.parametrize("delays", DELAYS.values(), ids=DELAYS.keys())


def truth(times: numpy.ndarray) -> numpy.ndarray:
    """Return the published sine."""
    return numpy.sin(2.0 * math.pi * SINE_HZ * (times - START))


def messages_of(delays: List[float]) -> List[BagMessage]:
    """Return the messages in order of receipt."""
    sent: List[BagMessage] = []
    for stamp, delay, value in zip(STAMPS, delays, truth(numpy.array(STAMPS)).tolist()):
        message = PointStamped()
        message.header.stamp = Time.from_sec(stamp)
        message.point.x = value
        sent.append((round((stamp + delay) * 1e9), "/s", message))
    return sorted(sent, key=lambda one: one[0])


def in_bag(delays: List[float], later: float = 0.0) -> List[BagMessage]:
    """Return the messages as in a bag that was recorded later by a time [s]."""
    more = round(later * 1e9) - BAG_BEGIN
    return [(time + more, topic, message) for time, topic, message in messages_of(delays)]


def recorded(delays: List[float], timestamp: str = "stamp") -> Trace:
    """Return the trace of the received messages, in batches of up to ten."""
    stream = Stream("/s", timestamp)
    trace = stream.record(("point", "x"), 100.0)
    layout, sent = layout_of(PointStamped), messages_of(delays)
    for start in range(0, COUNT, 10):
        some = sent[start : start + 10]
        data = []
        for _, _, message in some:
            file = io.BytesIO()
            message.serialize(file)
            data.append(file.getvalue())
        stream.add(layout, Batch({}, [time for time, _, _ in some], data))
    return trace


def check(times: Any, values: Any) -> None:
    """Compare samples with the sine."""
    times, values = numpy.array(times), numpy.array(values)
    assert times == pytest.approx(STAMPS, abs=1e-6)
    assert values == pytest.approx(truth(times), abs=1e-4)


def far_ahead() -> List[BagMessage]:
    """Return messages with one stamp more than an hour ahead."""
    sent = messages_of([0.0] * COUNT)
    sent[COUNT // 2][2].header.stamp += Duration(3950)
    return sent


@pytest.mark.parametrize("timestamp", ["stamp", ""])
def test_stamp_far_ahead_is_placed_at_receipt_and_displaces_nothing(timestamp: str) -> None:
    stream = Stream("/s", timestamp)
    trace = stream.record(("point", "x"), 100.0)
    for time, _, message in far_ahead():
        stream.add(layout_of(PointStamped), Batch({}, [time], [serialized(message)]))
    check(*trace.samples(-math.inf, math.inf))
    sent = [(time - BAG_BEGIN, topic, message) for time, topic, message in far_ahead()]
    column = EXACT._replace(timestamp=timestamp)
    (series,) = collect(reading([column], sent, BAG_BEGIN), slices(sent))
    there = numpy.isfinite(series.values)  # the automatic source ends the line at a clock set back
    check(START + numpy.array(series.times)[there], numpy.array(series.values)[there])


class OneTrace:
    """Recorder of one trace."""

    def __init__(self, trace: Trace) -> None:
        self._trace = trace

    def update(self) -> None:
        """Do nothing."""

    def trace(self, _name: str) -> Trace:
        """Return the trace."""
        return self._trace


@late
def test_samples_are_placed_at_their_stamps(delays: List[float]) -> None:
    times, values = recorded(delays).samples(0.0, 2000.0)
    check(times, values)
    turned = phase((times, values), (numpy.array(STAMPS), truth(numpy.array(STAMPS))), math.inf)
    assert turned.value == pytest.approx(0.0, abs=360.0 * SINE_HZ * PERIOD_S)


@late
def test_csv_of_the_page_has_stamps_and_receipt_times(delays: List[float]) -> None:
    async def text() -> str:
        one: Any = OneTrace(recorded(delays))
        return "".join([part async for part in parts(one, [NAME], 0.0, 2000.0)])

    head, *lines = asyncio.run(text()).splitlines()
    assert head == f"time,received,{NAME}"
    rows = numpy.array([[float(cell) for cell in line.split(",")] for line in lines])
    check(rows[:, 0], rows[:, 2])
    assert rows[:, 1] - rows[:, 0] == pytest.approx(delays, abs=1e-5)


@late
def test_plot_bag_draws_at_the_stamps(delays: List[float]) -> None:
    sent = in_bag(delays)
    (series,) = collect(reading([EXACT], sent, BAG_BEGIN), slices(sent))
    assert series.correction is None
    check(START + numpy.array(series.times), series.values)


@pytest.mark.parametrize(
    "delay, shift, words",
    [(0.3, 0.0, None), (0.8, 0.8, "stamps 0.80 s behind: shown at reception")],
)
def test_plot_bag_chooses_like_the_page_and_reports_corrections(
    delay: float, shift: float, words: Optional[str]
) -> None:
    sent = in_bag([delay] * COUNT)
    (series,) = collect(reading([EXACT._replace(timestamp="")], sent, BAG_BEGIN), slices(sent))
    assert series.correction == words
    assert series.title == (f"/s/point/x ({words})" if words else "/s/point/x")
    check(START + numpy.array(series.times) - shift, series.values)


def test_plot_bag_aligns_stamps_of_a_simulation_and_reports_it() -> None:
    sent = in_bag([0.0] * COUNT, -START * 1e3)
    for timestamp in ("stamp", ""):
        column = EXACT._replace(timestamp=timestamp)
        (series,) = collect(reading([column], sent, BAG_BEGIN), slices(sent))
        assert series.correction == "stamps of another clock: shown at reception"
        assert series.times[0] == pytest.approx(-START * 1e3, abs=0.01)


@late
def test_csv_of_plot_bag_uses_the_stamps(delays: List[float]) -> None:
    sent, file = in_bag(delays), io.StringIO()
    write_csv(file, reading([EXACT], sent, BAG_BEGIN), slices(sent))
    _, *lines = file.getvalue().splitlines()
    rows = sorted([float(cell) for cell in line.split(",")] for line in lines)
    check([START + time for time, _ in rows], [value for _, value in rows])


def test_csv_of_plot_bag_has_invalid_stamps_at_their_recording() -> None:
    sent, file = in_bag([0.0] * COUNT), io.StringIO()
    sent[10][2].header.stamp = Time(0)
    sent[20][2].header.stamp += Duration(20)
    write_csv(file, reading([EXACT], sent, BAG_BEGIN), slices(sent))
    _, *lines = file.getvalue().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines]
    check([START + time for time, _ in rows], [value for _, value in rows])


@late
def test_latency_equals_the_delay_of_messages(delays: List[float]) -> None:
    for timestamp in ("stamp", ""):
        latency = recorded(delays, timestamp).latency(0.0, 2000.0)
        assert numpy.median(latency) == pytest.approx(numpy.median(delays), abs=1e-5)
        assert latency.max() == pytest.approx(max(delays), abs=1e-5)
    assert not len(recorded(delays, "received").latency(0.0, 2000.0))


def test_late_trace_is_not_silent() -> None:
    assert recorded([5.0] * COUNT).silence(STAMPS[-1] + 5.5) == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize(
    "delay, words",
    [(0.3, None), (0.8, "stamps 0.80 s behind: shown at reception")],
)
def test_correction_of_the_chosen_source_is_reported(delay: float, words: Optional[str]) -> None:
    trace = recorded([delay] * COUNT, "")
    assert trace.stream.correction == words
    assert recorded([delay] * COUNT).stream.correction is None


@pytest.mark.parametrize(
    "offset, words",
    [
        (-2.0, "stamps 2.00 s ahead: shown at reception"),
        (1.7e9, "stamps of another clock: shown at reception"),
    ],
)
def test_early_stamps_are_distinguished_from_another_clock(offset: float, words: str) -> None:
    assert correction(("header", "stamp"), to_ns(offset)) == words
    assert correction(("time_x",), to_ns(offset)) is None
