"""A trace goes by the time of its messages, and stands where the scope's clock is."""

from typing import List

import numpy
import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg
from topic_scope.messages import timestamp_source
from topic_scope.messages.definitions import layout_of
from topic_scope.messages.fields import FieldError
from topic_scope.messages.timestamp_source import OwnClock

FIELD, STAMP = ("time_x",), ("header", "stamp")
EPOCH = 1.7e9


def taken(
    time: OwnClock, own: List[float], received: List[float], batch: int = 5
) -> "tuple[List[float], List[float]]":
    """Hand over messages in batches; return their own times and how far they were set back."""
    times: List[float] = []
    moves = []
    for start in range(0, len(own), batch):
        part = slice(start, start + batch)
        some, back = time.convert(numpy.array(own[part]), numpy.array(received[part]))
        times += list(some)
        moves += [back] if back else []
    return times, moves


def test_what_fits_best_is_chosen() -> None:
    paths = [
        timestamp_source.path_of("", layout_of(one)) for one in (PoseStamped, signal_msg, Float32)
    ]
    assert paths == [STAMP, FIELD, None]
    assert [timestamp_source.name_of(path) for path in paths] == ["stamp", "time_x", "received"]


def test_what_is_named_is_taken_or_refused_in_words() -> None:
    layout = layout_of(signal_msg)
    assert timestamp_source.path_of("received", layout) is None
    assert timestamp_source.path_of("time_x", layout) == FIELD
    for name in ("stamp", "time_y", "signal_y"):  # the last is too coarse for a time
        with pytest.raises(FieldError, match="there is no time .* in basic_comms/signal_msg"):
            timestamp_source.path_of(name, layout)


@settings(max_examples=30)
@given(
    st.floats(-1e9, 1e9),
    st.lists(st.floats(0.0, 0.04), min_size=20, max_size=200),
    st.integers(1, 50),
)
def test_delays_bend_nothing(begin: float, delays: List[float], batch: int) -> None:
    own = [begin + 0.05 * index for index in range(len(delays))]
    received = [EPOCH + 0.05 * index + delay for index, delay in enumerate(delays)]
    time = OwnClock(FIELD)
    assert taken(time, own, received, batch) == (own, [])
    shift = time.offset - (EPOCH - begin)
    assert min(delays) - 1e-6 <= shift <= max(delays) + timestamp_source.TOLERANCE_S + 1e-6


def test_a_trace_stands_still_once_enough_was_received() -> None:
    time, offsets = OwnClock(FIELD), []
    for index in range(1000):
        taken(time, [0.01 * index], [EPOCH + 0.01 * index + (0.02 if index > 300 else 0.0)])
        offsets.append(time.offset)
    assert len(set(offsets[250:])) == 1


def test_a_delay_of_a_while_does_not_move_the_trace() -> None:
    """A second in which all messages wait for each other, as on a machine that is busy."""
    moments = [0.01 * index for index in range(500)]
    received = [EPOCH + max(moment, 3.0 if 2.7 < moment < 3.0 else 0.0) for moment in moments]
    time, offsets = OwnClock(FIELD), []
    for own, came in zip(moments, received):
        taken(time, [own], [came])
        offsets.append(time.offset)
    assert max(offsets) - min(offsets) <= timestamp_source.TOLERANCE_S


def test_a_clock_that_is_set_back_begins_a_new_line() -> None:
    own = [50.0 + 0.1 * index for index in range(10)] + [0.1 * index for index in range(10)]
    received = [EPOCH + 0.1 * index for index in range(20)]
    time = OwnClock(FIELD)
    times, moves = taken(time, own, received)
    assert times == own
    assert moves == [pytest.approx(-51.0, abs=1e-6)]
    assert 50.9 + moves[0] + time.offset == pytest.approx(EPOCH + 0.9, abs=1e-6)
    assert time.offset == pytest.approx(EPOCH + 1.0, abs=1e-6)


def test_what_is_a_little_late_is_no_clock_set_back() -> None:
    own = [1.0, 1.1, 0.9, 1.2, 1.0]
    assert taken(OwnClock(FIELD), own, [EPOCH + 0.1 * index for index in range(5)], 1)[1] == []


def test_a_clock_at_half_speed_is_followed() -> None:
    time, now = OwnClock(FIELD), 0.0
    for index in range(2000):
        now = EPOCH + 0.01 * index
        taken(time, [0.005 * index], [now])
    # The median is that of one second ago, in which the clocks went apart by half a second.
    assert abs(0.005 * 1999 + time.offset - now) < 0.51 + timestamp_source.SETTLED_S


@pytest.mark.parametrize("ahead", [-0.4, 0.0, 0.4])
def test_stamps_of_the_same_clock_stay_as_they_are(ahead: float) -> None:
    time = OwnClock(STAMP)
    taken(time, [EPOCH + 0.1 * index + ahead for index in range(20)], moments(20))
    assert time.offset == 0.0


def test_stamps_of_another_clock_are_moved() -> None:
    time = OwnClock(STAMP)
    taken(time, [3.0 + 0.1 * index for index in range(20)], moments(20))
    assert time.offset == pytest.approx(EPOCH - 3.0, abs=1e-6)


def test_stamps_that_nobody_has_filled_in_are_as_received() -> None:
    time = OwnClock(STAMP)
    assert taken(time, [0.0] * 20, moments(20)) == (moments(20), [])
    assert time.offset == 0.0 and not time.is_said


@pytest.mark.parametrize("begin, other", [(3.0, True), (EPOCH - 0.4, False), (2 * EPOCH, True)])
def test_stamps_that_begin_later_leave_what_came_before_where_it_was_received(
    begin: float, other: bool
) -> None:
    """As of a node that is there before the first message on /clock."""
    time, own = OwnClock(STAMP), [0.0] * 10 + [begin + 0.1 * index for index in range(10, 20)]
    times, moves = taken(time, own, moments(20))
    assert time.offset == pytest.approx(EPOCH - begin if other else 0.0, abs=1e-6) and time.is_said
    there = [at + sum(moves) + time.offset for at in times[:10]]
    assert there == pytest.approx(moments(10), abs=1e-6)
    assert times[10:] == own[10:]


@pytest.mark.parametrize("nothing", [numpy.nan, numpy.inf, -1e300])
def test_what_is_no_time_counts_as_received(nothing: float) -> None:
    time = OwnClock(FIELD)
    own = [5.0, nothing, 5.2, nothing, 5.4]
    times, _ = taken(time, own, moments(5), 1)
    assert times == pytest.approx([5.0, 5.1, 5.2, 5.3, 5.4], abs=1e-6)


def test_several_missing_samples_end_a_line_and_a_delay_does_not() -> None:
    quick, slow = numpy.arange(100) * 0.001, numpy.arange(100) * 2.0
    assert timestamp_source.longest_step(FIELD, quick) == pytest.approx(0.005)
    assert timestamp_source.longest_step(None, quick) == 0.25
    assert (
        timestamp_source.longest_step(FIELD, slow)
        == timestamp_source.longest_step(None, slow)
        == 10.0
    )
    assert timestamp_source.longest_step(FIELD, slow[:3]) == numpy.inf


def moments(count: int) -> List[float]:
    """Return when messages at 10 Hz are received."""
    return [EPOCH + 0.1 * index for index in range(count)]
