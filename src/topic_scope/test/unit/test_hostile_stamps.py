"""Known signals in messages with hostile stamps: each sample has its time, each figure is true."""

from typing import Callable, Dict, List, NamedTuple, Tuple

import numpy
import pytest
from known_signals import Signal, signals
from test_known_signals import is_true, measures

from topic_scope.analysis.ring import Ring
from topic_scope.timing.clocks import Clocks
from topic_scope.timing.nanoseconds import NS, array_to_ns
from topic_scope.timing.topic_time import TopicTime

MS = NS // 1000
#: Time between the other messages of the topic [ns], and their number before and after a signal:
#: for as long as a message may be late.
STEP, LEAD, TRAIL = 20 * MS, 150, 300
#: Lag of the stamps of a simulation or an old recording [ns].
OLD = 1_600_000_000 * NS
#: Length of a batch of messages [ns].
BATCH = 250 * MS
SIGNALS = signals()


class Sent(NamedTuple):
    """Messages of a topic.

    :param stamps: their stamps [ns]
    :param received: times of receipt [ns]
    :param numbers: number of the sample in each
    """

    stamps: numpy.ndarray
    received: numpy.ndarray
    numbers: numpy.ndarray


Random = numpy.random.RandomState
#: Makes messages from the true times of samples [ns].
Sender = Callable[[numpy.ndarray, Random], Sent]


def late(times: numpy.ndarray, random: Random) -> Sent:
    """Deliver some messages up to 5 s late."""
    delays = random.randint(MS, 5 * NS, len(times)) * (random.uniform(size=len(times)) < 0.1)
    delays[-TRAIL:] = 0
    return Sent(times, times + delays, numpy.arange(len(times)))


def implausible(times: numpy.ndarray, _: Random) -> Sent:
    """Set some stamps far ahead or far behind."""
    stamps = times.copy()
    stamps[5::34] += 600 * NS
    stamps[22::34] -= 7000 * NS
    return Sent(stamps, times, numpy.arange(len(times)))


def doubled(times: numpy.ndarray, random: Random) -> Sent:
    """Send some messages twice."""
    numbers = numpy.arange(len(times))
    again = random.uniform(size=len(times)) < 0.1
    numbers = numpy.sort(numpy.append(numbers, numbers[again]))
    return Sent(times[numbers], times[numbers], numbers)


def disordered(times: numpy.ndarray, random: Random) -> Sent:
    """Deliver messages in another order."""
    received = times + random.randint(0, 300 * MS, len(times))
    return Sent(times, received, numpy.arange(len(times)))


def set_by(step: int) -> Sender:
    """Return a sender whose clock is set at the first sample of the signal."""

    def sent(times: numpy.ndarray, _: Random) -> Sent:
        stamps = numpy.where(times < times[LEAD], times, times + step)
        return Sent(stamps, times, numpy.arange(len(times)))

    return sent


def at_speed(speed: float) -> Sender:
    """Return a sender with another clock that has a speed."""

    def sent(times: numpy.ndarray, _: Random) -> Sent:
        received = times[0] + ((times - times[0]) / speed).astype(numpy.int64)
        return Sent(times - OLD, received, numpy.arange(len(times)))

    return sent


SENDERS: Dict[str, Sender] = {
    "late": late,
    "implausible": implausible,
    "doubled": doubled,
    "disordered": disordered,
    "set back": set_by(-30 * NS),
    "set ahead": set_by(30 * NS),
    **{f"speed {speed:g}": at_speed(speed) for speed in (0.1, 0.5, 1.0, 3.0, 10.0)},
}
#: Senders whose test takes seconds.
SLOW = ("disordered", "doubled", "set ahead", "speed 0.1", "speed 0.5")


def among_others(signal: Signal) -> numpy.ndarray:
    """Return the times of a signal and of the messages before and after it [ns]."""
    times = array_to_ns(signal.times)
    before = times[0] - STEP * numpy.arange(LEAD, 0, -1)
    return numpy.concatenate([before, times, times[-1] + STEP * numpy.arange(1, TRAIL + 1)])


def shown_of(signal: Signal, sender: Sender, number: int) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the times of a signal's samples as shown [ns], and their numbers.

    :param signal: the signal
    :param sender: makes the messages
    :param number: decides the random parts, and whether the stamps were selected
    """
    topic, ring = TopicTime(Clocks(), True, number % 2 == 1), Ring(1e9)
    sent = sender(among_others(signal), Random(number))
    order = sent.received.argsort(kind="stable")
    stamps, received, numbers = (part[order] for part in sent)
    start = 0
    for stop in [*(numpy.diff(received // BATCH).nonzero()[0] + 1), len(order)]:
        is_last = stop == len(order)
        for placed in topic.place(stamps[start:stop], received[start:stop], is_last):
            if placed.moved:
                ring.move(placed.moved)
            some = slice(start, start + len(placed.times))
            start = some.stop
            ring.append(placed.times, numbers[some], received[some], placed.newest)
    assert start == len(order)
    times, values, _ = ring.between(-(2**62), 2**62)
    part = (values >= LEAD) & (values < LEAD + len(signal.times))
    return times[part] + topic.clock.offset, values[part].astype(int) - LEAD


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(index, marks=[pytest.mark.extended] if name in SLOW else [])
        for index, name in enumerate(SENDERS)
    ],
    ids=list(SENDERS),
)
def test_known_signals_have_their_times_and_figures(index: int) -> None:
    """Each of the two hundred signals has one kind of stamps."""
    wrong: List[object] = []
    sender = list(SENDERS.values())[index]
    for number in range(index, len(SIGNALS), len(SENDERS)):
        signal = SIGNALS[number]
        if sender is late and signal.kind == "gap":
            continue  # late messages that agree, and no others: their clock was set
        times, numbers = shown_of(signal, sender, number)
        apart = times - array_to_ns(signal.times)[numbers]
        if len(set(numbers)) < len(signal.times) or (apart != apart[0]).any():
            wrong.append((number, signal.kind, len(set(numbers)), len(signal.times), apart))
        shown = signal._replace(times=(times - apart[0]) / NS, values=signal.values[numbers])
        wrong += [
            (number, signal.kind, name, figure, signal.truth.get(name))
            for name, figure in measures(shown).items()
            if not is_true(name, figure, signal)
        ]
    assert not wrong
