"""Bag player with pause, seek and speed: a message source inside the scope, without ROS topics.

The bag is read in the thread that calls :meth:`now`, a few chunks at each call, so no locks or
queues are needed, and only the messages between the chunks in progress and the clock are in memory.
After a seek, the player first reads the history before the new position, as fast as possible, and
then follows the clock.
"""

import time
from collections import deque
from typing import Callable, Collection, Deque, Dict, Iterator, List, Mapping, Set, Tuple

import numpy

from topic_scope.bag.recording import BagError, ConnectionMessages, Recording
from topic_scope.sampling.message_source import TICK_NS, Batch

#: Longest reading time of a call [s]: while pages are updated, and while they wait.
PLAYING_S, LOADING_S = 0.01, 0.1
#: Bytes of messages, such as images, after which a call stops reading.
MOST_BYTES = 16 * 10**6
_NS = 10**9
#: History before a position for side subscriptions [ns].
ASIDE_NS = 5 * _NS


class Subscription:
    """Queue of the played messages of one topic."""

    def __init__(self) -> None:
        self.batches: List[Batch] = []

    def drain(self) -> Iterator[Batch]:
        """Return the messages since the last call, oldest first."""
        batches, self.batches = self.batches, []
        return iter(batches)


class RecentSubscriptions:
    """Second set of subscriptions to a played bag; a :class:`.MessageSource`.

    After a seek it receives only the last seconds of the history, and at least the latest message
    of each publisher, however old: its users need the present only.

    :param player: player of the bag
    """

    def __init__(self, player: "BagPlayer") -> None:
        self.clock = player
        self.active: Dict[str, Subscription] = {}
        self.wanted: Set[str] = set()

    @property
    def has_ended(self) -> bool:
        """Whether the clock of the bag has reached its end."""
        return self.clock.has_ended

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Request the messages of these topics from the next :meth:`BagPlayer.seek` on."""
        self.wanted = set(topics)
        self.active = {topic: one for topic, one in self.active.items() if topic in self.wanted}
        if is_more or self.wanted - set(self.active):
            self.clock.lacks_past = True

    def subscriptions(self) -> Mapping[str, Subscription]:
        """Return the subscriptions by topic."""
        return self.active


class BagPlayer:
    """Player of a bag; a :class:`.MessageSource`.

    :param bag: the bag
    :param history: history to read before a position [s]
    :param clock: monotonic clock [s]

    :ivar aside: second set of subscriptions
    :ivar is_loading: whether the history is being read
    :ivar lacks_past: whether topics were requested whose history has not been read
    :ivar is_playing: whether its clock runs, or will run after loading
    :ivar problems: problems of reading
    """

    def __init__(
        self, bag: Recording, history: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._bag, self._clock = bag, clock
        self._history = round(history * _NS)
        self._wanted: Set[str] = set()
        self._subscriptions: Dict[str, Subscription] = {}
        self.aside = RecentSubscriptions(self)
        self._connections: Set[int] = set()
        #: Chunks to read, as number and start [ns]; and messages read ahead of the clock.
        self._chunks: Deque[Tuple[int, int]] = deque()
        self._parts: List[ConnectionMessages] = []
        #: Output time of the latest message of each topic [ns].
        self._latest: Dict[str, int] = {}
        #: All messages up to this time have been output; and the target of a seek [ns].
        self._at = self._goal = self._start = self._recent = bag.start
        #: Reference of its clock: monotonic time [s], and position in the bag [ns].
        self._since, self._from = clock(), bag.start
        self._speed = 1.0
        self.is_loading = self.is_playing = self.lacks_past = False
        self.problems: Deque[str] = deque(maxlen=10)

    # --- Requests ----------------------------------------------------------------------------

    @property
    def start(self) -> float:
        """Time of the first message [s] since the epoch."""
        return self._bag.start / _NS

    @property
    def end(self) -> float:
        """Time of the last message [s] since the epoch."""
        return self._bag.end / _NS

    @property
    def place(self) -> float:
        """Present time of its clock, or the target of a seek [s since the epoch]."""
        return self._goal / _NS

    @property
    def speed(self) -> float:
        """Playback speed relative to the recording."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self.now()
        self._speed = speed
        self._count_from_here()

    def play(self) -> None:
        """Start the clock; it stops at the end of the bag."""
        self.is_playing = True
        self._count_from_here()

    def pause(self) -> None:
        """Stop the clock."""
        self.now()
        self.is_playing = False

    def seek(self, moment: float) -> None:
        """Move to a time: read the history before it, then continue as before.

        :param moment: s since the epoch; limited to the bag
        """
        # The end, rounded to a float, may be before the last message.
        goal = self._bag.end if moment >= self.end else round(moment * _NS)
        self._goal = min(max(goal, self._bag.start), self._bag.end)
        self._at = self._start = max(self._goal - self._history, self._bag.start) - 1
        self._recent = self._goal - ASIDE_NS
        self._subscriptions, wanted = self._subscriptions_of(self._wanted)
        self.aside.active, besides = self._subscriptions_of(self.aside.wanted)
        self._connections = {*wanted, *besides}
        self._chunks = deque(zip(*self._bag.chunks_after(self._at, besides)))
        self._parts, self._latest = [], {}
        self.is_loading, self.lacks_past = True, False

    def _subscriptions_of(
        self, topics: Collection[str]
    ) -> Tuple[Dict[str, Subscription], List[int]]:
        connections = self._bag.connections
        numbers = [number for number, one in connections.items() if one.topic in topics]
        return {connections[number].topic: Subscription() for number in numbers}, numbers

    # --- MessageSource -----------------------------------------------------------------------

    @property
    def clock(self) -> "BagPlayer":
        """Clock of the messages' times."""
        return self

    @property
    def has_ended(self) -> bool:
        """Whether its clock has reached the end of the bag."""
        return self._at >= self._bag.end

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Request the messages of these topics from the next :meth:`seek` on."""
        self._wanted = set(topics)
        self.lacks_past = self.lacks_past or is_more

    def subscriptions(self) -> Mapping[str, Subscription]:
        """Return the subscriptions by topic."""
        return self._subscriptions

    def now(self) -> float:
        """Read the next chunks, and output messages.

        :returns: the time up to which all messages have been output [s] since the epoch
        """
        passed = self._clock()
        target = self._goal
        if self.is_playing and not self.is_loading:
            since = round((passed - self._since) * self._speed * _NS)
            target = min(self._from + since, self._bag.end)
        reached = self._read(target, passed + (LOADING_S if self.is_loading else PLAYING_S))
        self._at = max(self._at, reached)
        self._put()
        if self.is_loading:
            self.is_loading = reached < target
            self._count_from_here()
        else:
            self._goal = self._at
            if reached < target:  # reading is slower than the clock
                self._count_from_here()
            self.is_playing = self.is_playing and reached < self._bag.end
        return self._at / _NS

    def _count_from_here(self) -> None:
        self._since, self._from = self._clock(), self._goal

    def _read(self, target: int, until: float) -> int:
        """Read chunks, at least one.

        :param target: read the chunks that start up to here [ns]
        :param until: time to stop [s]
        :returns: the time up to which all messages have been read [ns]
        """
        is_late, size = False, 0
        while self._chunks:
            number, begin = self._chunks[0]
            if begin > target:
                break
            if is_late:
                return begin - 1
            self._chunks.popleft()
            try:
                parts = self._bag.read(number, self._connections)
                size += sum(sum(map(len, part.messages)) for part in parts)
                self._parts += parts
            except BagError as error:  # other chunks may be intact
                self.problems.append(str(error))
            self.problems += self._bag.notes
            self._bag.notes.clear()
            is_late = size >= MOST_BYTES or self._clock() >= until
        return target

    def _put(self) -> None:
        """Output the messages up to the time of the clock."""
        parts, self._parts = self._parts, []
        ready: Dict[str, List[ConnectionMessages]] = {}
        for connection, times, messages in parts:
            last = int(times.searchsorted(self._at, "right"))
            if last:
                topic = self._bag.connections[connection].topic
                ready.setdefault(topic, []).append(
                    ConnectionMessages(connection, times[:last], messages[:last])
                )
            if last < len(messages):
                self._parts.append(ConnectionMessages(connection, times[last:], messages[last:]))
        for topic, found in ready.items():
            output = distinct_times([part.times for part in found], self._latest.get(topic, 0))
            self._latest[topic] = max(int(one[-1]) for one in output)
            for part, one in zip(found, output):
                self._let_out(topic, part, one.tolist())

    def _let_out(self, topic: str, part: ConnectionMessages, times: List[int]) -> None:
        header = self._bag.connections[part.connection].header
        first, recent = part.times.searchsorted([self._start, self._recent], "right").tolist()
        recent = min(recent, len(times) - 1)
        for subscriptions, begin in ((self._subscriptions, first), (self.aside.active, recent)):
            if topic in subscriptions and begin < len(times):
                batch = Batch(header, times[begin:], part.messages[begin:])
                subscriptions[topic].batches.append(batch)


def distinct_times(recorded: List[numpy.ndarray], latest: int) -> List[numpy.ndarray]:
    """Return the output times of the messages of a topic, no two equal.

    :param recorded: times of recording for each part, ascending [ns]
    :param latest: output time of the latest earlier message [ns]
    """
    times = numpy.concatenate(recorded)
    order = times.argsort(kind="stable")
    ticks = TICK_NS * numpy.arange(1, len(times) + 1)
    output = numpy.empty_like(times)
    output[order] = numpy.maximum.accumulate(numpy.maximum(times[order] - ticks, latest)) + ticks
    return numpy.split(output, numpy.cumsum([len(one) for one in recorded])[:-1])
