"""Placement of samples at their stamps, for all cases of stamps around them."""

from typing import Any, Callable, List, NamedTuple, Tuple, cast

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.timing.clocks import Clock, Clocks
from topic_scope.timing.lag import SETTLED_NS, TOLERANCE_NS, Lag
from topic_scope.timing.nanoseconds import NO_TIME, NS, array_to_ns, to_ns
from topic_scope.timing.topic_time import PlacedMessages, TopicTime

EPOCH = 1_700_000_000 * NS
MS = NS // 1000


class Delay:
    """Lag that does not change."""

    received = 0

    def expected(self, _now: int) -> int:
        return 5 * NS


def test_clock_that_has_its_offset_does_not_change_again() -> None:
    clock, lag = Clock(), Delay()
    clock.members.add(cast(Any, lag))
    assert clock.follow(0) and clock.offset == 5 * NS
    assert not clock.follow(0)


class Shown(NamedTuple):
    """Shown samples of a topic.

    :param times: times of its samples by the scope's clock, in order of receipt [ns]
    :param gaps: indices of the samples after the end of a line
    """

    times: numpy.ndarray
    gaps: List[int]


class Topic:
    """Topic whose messages arrive in batches.

    :param clocks: clocks of all topics
    :param is_stamp: whether it has stamps; otherwise numbers with an unknown zero
    :param is_exact: whether its stamps were selected
    """

    def __init__(self, clocks: Clocks, is_stamp: bool = True, is_exact: bool = False) -> None:
        self.time = TopicTime(clocks, is_stamp, is_exact)
        self._own = self._received = numpy.empty(0, numpy.int64)
        self._placed = numpy.empty(0, numpy.int64)
        self._gaps: List[int] = []

    def take(self, own: numpy.ndarray, received: numpy.ndarray, is_final: bool = False) -> None:
        """Add messages."""
        self._own = numpy.append(self._own, own)
        self._received = numpy.append(self._received, received)
        for placed in self.time.place(self._own, self._received, is_final):
            self._show(placed)

    def _show(self, placed: PlacedMessages) -> None:
        count = len(placed.times)
        self._own, self._received = self._own[count:], self._received[count:]
        if placed.moved and len(self._placed):
            self._gaps.append(len(self._placed))
        self._placed = numpy.append(self._placed + placed.moved, placed.times)

    def shown(self) -> Shown:
        """Return all samples after the last message."""
        self.take(self._own[:0], self._own[:0], True)
        assert not len(self._own), "each message is placed"
        return Shown(self._placed + self.time.clock.offset, self._gaps)


def played(
    own: numpy.ndarray,
    received: numpy.ndarray,
    is_exact: bool = False,
    batch: int = 5,
    is_stamp: bool = True,
) -> Tuple[Topic, Shown]:
    """Return a topic whose messages arrived in batches, and its shown samples."""
    topic = Topic(Clocks(), is_stamp, is_exact)
    for start in range(0, len(own), batch):
        part = slice(start, start + batch)
        topic.take(own[part], received[part])
    return topic, topic.shown()


def at_50_hz(count: int = 500) -> numpy.ndarray:
    """Return times since the epoch [ns]."""
    return numpy.asarray(EPOCH + 20 * MS * numpy.arange(count))


both = pytest.mark.parametrize("is_exact", [False, True], ids=["chosen", "named"])


# --- One message that the others contradict ----------------------------------------------------


@both
@pytest.mark.parametrize("batch", [1, 7, 500])
@pytest.mark.parametrize("late", [600 * MS, 20 * NS, 600 * NS])
def test_late_message_is_placed_at_its_stamp_and_moves_no_other(
    late: int, batch: int, is_exact: bool
) -> None:
    received = at_50_hz()
    own = received.copy()
    own[230] -= late
    topic, shown = played(own, received, is_exact, batch)
    assert shown.times.tolist() == own.tolist() and not shown.gaps
    assert topic.time.outliers.text == f"1 stamp up to {late / NS:.2f} s late"


@both
def test_largest_delay_and_lead_are_reported(is_exact: bool) -> None:
    received = at_50_hz()
    own = received.copy()
    own[[100, 200]] -= numpy.array([20 * NS, 600 * MS])
    own[[300, 400]] += numpy.array([-7200 * NS, 600 * NS])
    topic, _ = played(own, received, is_exact)
    late, rejected = topic.time.outliers.text.split("; ")
    assert late == "2 stamps up to 20.00 s late"
    assert rejected == "2 stamps up to 7200 s behind: shown at reception"


@both
@pytest.mark.parametrize("batch", [1, 7, 500])
@pytest.mark.parametrize("index", [0, 1, 230, 499])
@pytest.mark.parametrize(
    ("lead", "text"), [(600, "600 s ahead"), (-7200, "7200 s behind")], ids=["ahead", "behind"]
)
def test_implausible_stamp_is_placed_at_receipt_and_reported(
    lead: int, text: str, index: int, batch: int, is_exact: bool
) -> None:
    received = at_50_hz()
    own = received.copy()
    own[index] += lead * NS
    topic = Topic(Clocks(), True, is_exact)
    for start in range(0, 500, batch):
        topic.take(own[start : start + batch], received[start : start + batch])
    shown = topic.shown()
    assert abs(shown.times - received).max() <= 1 * MS
    if index:
        assert topic.time.outliers.rejected == 1
        assert topic.time.outliers.text.startswith(f"1 stamp up to {text}: shown at reception")


@both
def test_early_message_is_placed_at_its_stamp_and_makes_no_other_late(is_exact: bool) -> None:
    received = at_50_hz()
    own = received.copy()
    own[230] += 2 * NS
    topic, shown = played(own, received, is_exact)
    assert shown.times.tolist() == own.tolist()
    assert topic.time.outliers.text == "1 stamp early"


@both
def test_a_message_that_is_less_late_than_others_is_not_early(is_exact: bool) -> None:
    stamps = at_50_hz()
    received = stamps + (450 if not is_exact else 900) * MS
    received[100:500:50] = stamps[100:500:50] + 10 * MS
    order = received.argsort(kind="stable")
    topic, shown = played(stamps[order], received[order], is_exact)
    assert shown.times.tolist() == stamps[order].tolist() and not topic.time.outliers.early


@both
def test_history_counts_from_the_newest_plausible_stamp(is_exact: bool) -> None:
    received = at_50_hz()
    own = received.copy()
    own[[50, 100, 230]] += [2 * NS, 600 * NS, 9 * NS]
    time = TopicTime(Clocks(), True, is_exact)
    newest = [placed.newest for placed in time.place(own, received, True)]
    assert max(newest) == int(received[-1]) and newest == sorted(newest)


@both
def test_doubled_and_disordered_stamps_are_kept(is_exact: bool) -> None:
    received = at_50_hz()
    own = received.copy()
    own[100] = own[99]
    own[200:220] = own[200:220][::-1]
    topic, shown = played(own, received, is_exact)
    assert shown.times.tolist() == own.tolist() and not topic.time.outliers.text


@both
def test_emptied_queue_does_not_set_the_clock(is_exact: bool) -> None:
    """Twenty messages arrive together, after newer messages of another publisher."""
    received = at_50_hz()
    own = received.copy()
    own[200:220] -= 5 * NS
    received[200:220] = received[200] + numpy.arange(20) * MS // 10
    topic, shown = played(own, received, is_exact)
    assert shown.times.tolist() == own.tolist() and not shown.gaps
    assert topic.time.outliers.late == 20


@both
def test_two_publishers_a_second_apart_are_placed_at_their_stamps(is_exact: bool) -> None:
    received = at_50_hz()
    own = received.copy()
    own[1::2] -= NS
    _, shown = played(own, received, is_exact)
    assert shown.times.tolist() == own.tolist() and not shown.gaps


# --- A clock that was set ------------------------------------------------------------------------


@both
@pytest.mark.parametrize("batch", [1, 7, 500])
@pytest.mark.parametrize("back", [2 * NS, 50 * NS, 5000 * NS])
def test_clock_set_back_starts_a_line_if_later_messages_agree(
    back: int, batch: int, is_exact: bool
) -> None:
    received = at_50_hz()
    own = received - EPOCH + 10_000 * NS
    own[250:] -= back
    topic, shown = played(own, received, is_exact, batch)
    assert shown.gaps == [250] and not topic.time.outliers.text
    assert abs(shown.times - received).max() <= 1 * MS


def test_samples_stay_if_a_clock_is_set_again_as_soon_as_it_has_settled() -> None:
    """The first messages after it was set are late, which is known 2 s later."""
    received = at_50_hz()
    own = received - 1000 * NS
    own[200:] -= 500 * NS
    own[200:211] -= 600 * MS
    own[311:] -= 500 * NS
    _, shown = played(own, received, batch=1)
    assert shown.gaps == [200, 311]
    assert shown.times[:200].tolist() == received[:200].tolist()


def after_a_pause(late: List[int]) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return stamps and receipts at 50 Hz, with a pause of 1 s with late messages [ms] in it."""
    usual = at_50_hz()
    usual[250:] += NS
    arrived = EPOCH + 5200 * MS + 150 * MS * numpy.arange(len(late))
    own = numpy.insert(usual, 250, arrived - MS * numpy.array(late))
    return own, numpy.insert(usual, 250, arrived)


def test_messages_with_different_delays_in_a_pause_do_not_set_a_clock() -> None:
    own, received = after_a_pause([3900, 1200, 2700])
    _, shown = played(own, received)
    assert shown.times.tolist() == own.tolist() and not shown.gaps


def test_messages_before_a_clock_that_only_seemed_set_stay() -> None:
    own, received = after_a_pause([3000, 3000, 3000])
    _, shown = played(own, received)
    assert shown.times[:250].tolist() == own[:250].tolist()
    assert shown.times[-100:].tolist() == own[-100:].tolist()


def test_last_two_messages_may_set_a_clock() -> None:
    own = array_to_ns(numpy.array([5.0, 5.1, 5.2, 0.0, 0.1]))
    received = EPOCH + 100 * MS * numpy.arange(5)
    _, shown = played(own, received, is_stamp=False)
    assert shown.gaps == [3] and shown.times.tolist() == received.tolist()


def test_last_two_messages_may_arrive_together_and_set_a_clock() -> None:
    own = array_to_ns(numpy.array([5.0, 5.1, 5.2, 0.0, 0.1]))
    received = EPOCH + MS * numpy.array([0, 100, 200, 300, 301])
    _, shown = played(own, received, is_stamp=False)
    assert shown.gaps == [3] and shown.times[4] - shown.times[3] == 100 * MS


def test_a_slow_topic_follows_a_clock_that_its_neighbour_has_found() -> None:
    clocks = Clocks()
    quick, slow = Topic(clocks), Topic(clocks)
    for second in range(20):
        back = 100 * NS if second >= 10 else 0
        received_at = EPOCH + second * NS + 20 * MS * numpy.arange(50)
        quick.take(received_at - EPOCH + 1000 * NS - back, received_at)
        slow.take(received_at[-1:] - EPOCH + 1000 * NS - back, received_at[-1:])
    quick.shown(), slow.shown()
    assert quick.time.clock is slow.time.clock
    assert slow.shown().gaps == [10]


@both
def test_later_stamps_do_not_move_earlier_samples(
    is_exact: bool,
) -> None:
    """As for a node that runs before the first message on /clock."""
    received = at_50_hz(100)
    own = numpy.where(numpy.arange(100) < 50, NO_TIME, received - EPOCH + 3 * NS)
    topic, shown = played(own, received, is_exact)
    assert shown.times.tolist() == received.tolist() and shown.gaps == [50]
    assert topic.time.has_stamps


def test_unset_stamps_use_the_receipt_time() -> None:
    received = at_50_hz(20)
    topic, shown = played(numpy.full(20, NO_TIME), received)
    assert shown.times.tolist() == received.tolist() and not topic.time.has_stamps


def test_the_first_messages_decide_for_two_seconds_only() -> None:
    """A latched message with a stamp of five seconds ago arrives before the others."""
    received = at_50_hz()
    own = received.copy()
    own[0] -= 5 * NS
    topic, shown = played(own, received, batch=1)
    assert topic.time.clock.is_scope and shown.times[1:].tolist() == own[1:].tolist()


@pytest.mark.parametrize("delay_at", [lambda at: 0.45 + 0.02 * at, lambda at: 0.55 - 0.02 * at])
def test_choice_is_made_once_with_varying_latency(delay_at: Callable[[float], float]) -> None:
    """Around half a second, the limit between one clock and another."""
    topic, is_moved = Topic(Clocks()), set()
    for index in range(1000):
        own = numpy.array([EPOCH + 10 * MS * index])
        topic.take(own, own + to_ns(delay_at(0.01 * index)))
        is_moved.add(topic.time.clock.offset != 0)
    assert len(is_moved) == 1


# --- Several topics of one clock -----------------------------------------------------------------

#: Offsets of stamps with another zero [ns].
ELSEWHERE = {"replay": -40_000_000 * NS, "simulation": -EPOCH, "machine": -3 * NS}


@both
@pytest.mark.parametrize("delays", [(0, 100), (100, 0), (0, 400), (250, 0)])
@pytest.mark.parametrize("elsewhere", ELSEWHERE.values(), ids=ELSEWHERE.keys())
def test_topics_of_one_clock_are_moved_together(
    elsewhere: int, delays: Tuple[int, int], is_exact: bool
) -> None:
    clocks = Clocks()
    topics = [Topic(clocks, True, is_exact) for _ in delays]
    stamps = at_50_hz()
    for start in range(0, 500, 5):
        part = stamps[start : start + 5]
        for topic, delay in zip(topics, delays):
            topic.take(part + elsewhere, part + delay * MS)
    first, second = (topic.shown().times for topic in topics)
    assert first.tolist() == second.tolist()


@pytest.mark.parametrize(
    "speed",
    [
        pytest.param(0.1, marks=pytest.mark.extended),
        pytest.param(0.5, marks=pytest.mark.extended),
        pytest.param(1.0, marks=pytest.mark.extended),
        2.0,
        10.0,
    ],
)
def test_topics_of_a_replay_at_another_speed_differ_by_their_stamps(speed: float) -> None:
    """Both have the same stamps; one was recorded 0.1 s later."""
    clocks = Clocks()
    topics, delays = [Topic(clocks), Topic(clocks)], (0, 100 * MS)
    stamps = EPOCH - 10_000_000 * NS + 10 * MS * numpy.arange(3000)
    sent = [EPOCH + ((stamps - stamps[0] + delay) / speed).astype(numpy.int64) for delay in delays]
    now, done = EPOCH, [0, 0]
    behind = []
    while min(done) < len(stamps):
        now += 25 * MS
        for index, topic in enumerate(topics):
            end = int(sent[index].searchsorted(now))
            if end > done[index]:
                part = slice(done[index], end)
                topic.take(stamps[part], sent[index][part])
                done[index] = end
        if done[0] == len(stamps):
            break
        behind.append(now - int(stamps[done[0] - 1]) - topics[0].time.clock.offset)
        if topics[1].time.has_stamps:
            assert topics[0].time.clock is topics[1].time.clock
    assert all(topic.time.outliers.rejected == 0 for topic in topics)
    # The latest sample is near the present, within the batch length and the tolerance.
    settled = numpy.abs(numpy.array(behind[len(behind) // 2 :])) / NS
    assert settled.max() < 0.25 + 0.05 * speed


def test_topic_with_a_chosen_clock_does_not_move_that_clock() -> None:
    clocks = Clocks()
    leader, other = Topic(clocks), Topic(clocks)
    other.time.choose(lambda: leader.time.clock)
    received = at_50_hz(200)
    for start in range(0, 200, 5):
        part = received[start : start + 5]
        leader.take(part - 5800 * MS, part)
        other.take(part - 5000 * MS, part)
    assert other.time.clock is leader.time.clock
    assert leader.time.clock.offset == 5800 * MS


def test_nodes_with_their_own_zero_are_independent() -> None:
    """Two nodes started 0.3 s apart count from zero; a copy of one's times follows it."""
    clocks = Clocks()
    one, other, copied = (Topic(clocks, is_stamp=False) for _ in range(3))
    steps = 10 * MS * numpy.arange(500) + 1234
    for start in range(0, 500, 5):
        part = steps[start : start + 5]
        one.take(part, EPOCH + part)
        other.take(part, EPOCH + part + 300 * MS)
        copied.take(part, EPOCH + part + 3 * MS)
    assert one.shown().times.tolist() == copied.shown().times.tolist()
    assert (other.shown().times - one.shown().times).tolist() == [300 * MS] * 500


# --- Delays --------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(
    st.integers(-(10**9), 10**9),
    st.lists(st.integers(0, 40 * MS), min_size=20, max_size=200),
    st.integers(1, 50),
)
def test_delays_do_not_distort(begin: int, delays: List[int], batch: int) -> None:
    own = begin * NS + 50 * MS * numpy.arange(len(delays))
    received = EPOCH + 50 * MS * numpy.arange(len(delays)) + numpy.array(delays)
    topic, shown = played(own, received, batch=batch, is_stamp=False)
    assert numpy.diff(shown.times).tolist() == numpy.diff(own).tolist()
    shift = topic.time.clock.offset - (EPOCH - begin * NS)
    assert min(delays) <= shift <= max(delays) + TOLERANCE_NS


@settings(max_examples=60)
@given(st.data())
def test_each_message_is_placed_once_with_any_stamps(data: st.DataObject) -> None:
    """Late, early, duplicate and disordered stamps, set clocks, and missing times."""
    count = data.draw(st.integers(1, 120))
    received = (
        EPOCH
        + numpy.cumsum(data.draw(st.lists(st.integers(1, 300), min_size=count, max_size=count)))
        * MS
    )
    speed = data.draw(st.sampled_from([0.1, 0.5, 1.0, 3.0, 10.0]))
    own = EPOCH + ((received - EPOCH) * speed).astype(numpy.int64)
    for index in data.draw(st.lists(st.integers(0, count - 1), max_size=8)):
        own[index] += data.draw(st.sampled_from([-5000, -20, -1, 1, 9, 700, 9999])) * NS
    for index in data.draw(st.lists(st.integers(0, count - 1), max_size=2)):
        own[index:] += data.draw(st.sampled_from([-5000, -20, 20, 5000])) * NS
    own[data.draw(st.lists(st.integers(0, count - 1), max_size=3))] = NO_TIME
    batch, is_exact = data.draw(st.integers(1, 30)), data.draw(st.booleans())
    topic, shown = played(own, received, is_exact, batch)
    assert len(shown.times) == count
    assert (numpy.abs(shown.times - received) < 100_000 * NS).all()


def test_trace_does_not_move_once_settled() -> None:
    topic, offsets = Topic(Clocks()), []
    for index in range(1000):
        received_at = EPOCH + 10 * MS * index + (20 * MS if index > 300 else 0)
        topic.take(numpy.array([10 * MS * index]), numpy.array([received_at]))
        offsets.append(topic.time.clock.offset)
    assert len(set(offsets[250:])) == 1


def test_temporary_delay_does_not_move_the_trace() -> None:
    """For a second all messages are delayed, as on a busy machine."""
    topic, offsets = Topic(Clocks()), []
    for index in range(500):
        own = 10 * MS * index
        received_at = EPOCH + max(own, 3 * NS if 2700 * MS < own < 3 * NS else 0) + index
        topic.take(numpy.array([own]), numpy.array([received_at]))
        offsets.append(topic.time.clock.offset)
    assert max(offsets) - min(offsets) <= TOLERANCE_NS


@pytest.mark.parametrize("ahead", [-400, 0, 400])
def test_stamps_of_the_same_clock_stay_as_they_are(ahead: int) -> None:
    received = at_50_hz(100)
    topic, shown = played(received + ahead * MS, received)
    assert topic.time.clock.is_scope and shown.times.tolist() == (received + ahead * MS).tolist()


def test_message_waits_no_longer_than_its_patience() -> None:
    topic = Topic(Clocks())
    received = at_50_hz(100)
    topic.take(received, received)
    assert topic.time.patience == NS
    topic.take(received[-1:] - 50 * NS, received[-1:] + 20 * MS)
    assert len(topic._own) == 1
    slow = Topic(Clocks())
    slow.take(EPOCH + 5 * NS * numpy.arange(4), EPOCH + 5 * NS * numpy.arange(4))
    assert slow.time.patience > 10 * NS


def test_lag_of_a_slower_simulation_is_current() -> None:
    topic = Topic(Clocks())
    for index in range(2000):
        topic.take(numpy.array([5 * MS * index]), numpy.array([EPOCH + 10 * MS * index]))
    behind = EPOCH + 10 * MS * 1999 - 5 * MS * 1999 - topic.time.clock.offset
    assert abs(behind) <= SETTLED_NS + 20 * MS


# --- Stamps without a clock -----------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["countdown", "random", "backwards from 3 s on"])
@pytest.mark.parametrize("is_stamp", [False, True])
def test_no_message_waits_for_longer_than_the_patience(kind: str, is_stamp: bool) -> None:
    received = at_50_hz(1000)
    elapsed = received - EPOCH
    own = {
        "countdown": 20 * NS - elapsed,
        "random": numpy.random.default_rng(1).integers(0, 10**6 * NS, 1000),
        "backwards from 3 s on": numpy.where(elapsed < 3 * NS, elapsed, 6 * NS - elapsed),
    }[kind]
    topic = Topic(Clocks(), is_stamp)
    for start in range(0, 1000, 5):
        topic.take(own[start : start + 5], received[start : start + 5])
        waiting = topic._received
        if len(waiting):
            assert waiting[-1] - waiting[0] <= topic.time.patience + 100 * MS
    assert len(topic.shown().times) == 1000


def clock_with(clocks: Clocks, lag: int, received: int) -> Tuple[Clock, Lag]:
    """Return a clock with one topic, of which one message was received."""
    when = numpy.array([received])
    clock, topic = clocks.find(when - lag, when, True, False), Lag()
    topic.begin(lag, received)
    topic.received = received
    clock.members.add(topic)
    return clock, topic


def test_offset_of_a_bag_is_that_of_its_first_seconds() -> None:
    clocks = Clocks(3 * NS)
    clock, topic = clock_with(clocks, 100 * NS, 1000 * NS)
    offsets = []
    for second in (1, 5):
        topic.received = (1000 + second) * NS
        topic.usual += NS // 10
        clocks.follow(clock, topic.received)
        offsets.append(clock.offset)
    assert offsets == [100 * NS + NS // 10] * 2 and clocks.changes == 1


def test_clock_that_a_topic_has_left_is_not_found_again_for_it() -> None:
    clocks = Clocks()
    clock, topic = clock_with(clocks, 1000 * NS, 2000 * NS)
    later = numpy.array([2001 * NS])
    stamps = later - 1001 * NS  # one of its topics would be placed with this lag
    assert clocks.find(stamps, later, True, False) is clock
    assert clocks.find(stamps, later, True, False, left=clock) is not clock
    assert topic in clock.members


def test_drifting_clock_is_where_its_latest_topic_is() -> None:
    clocks = Clocks()
    clock, early = clock_with(clocks, 1000 * NS, 2000 * NS)
    latest = Lag()
    latest.begin(1000 * NS, 2010 * NS)
    latest.received, latest.drift = 2010 * NS, 0.5
    clock.members.add(latest)
    assert clock.expected(2012 * NS) == clock.offset + NS
    assert early in clock.members


def test_first_stamps_count_as_a_change_of_the_clocks() -> None:
    clocks = Clocks()
    time = TopicTime(clocks)
    received = numpy.array([2000 * NS])
    time.place(numpy.array([NO_TIME]), received)
    assert clocks.changes == 0
    time.place(received - 5 * NS, received + NS)
    assert clocks.changes == 1
