# Pure: knows no ROS.
"""Streams of all recorded topics, and the clocks that place their messages."""

from typing import Collection, Dict, Iterator, List, Optional, Tuple

from topic_scope.messages.fields import FieldError
from topic_scope.sampling.traces import MessageSink, Stream
from topic_scope.timing.clocks import Clock, Clocks


class Streams:
    """Streams by topic and timestamp source.

    :ivar clocks: the clocks of all topics
    """

    def __init__(self) -> None:
        self.clocks = Clocks()
        self._streams: Dict[Tuple[str, str], Stream] = {}
        #: Topics whose clocks are used, by the topics for which the user chose them.
        self._leaders: Dict[str, str] = {}

    def __iter__(self) -> Iterator[Stream]:
        return iter(self._streams.values())

    @property
    def topics(self) -> List[str]:
        """Topics of the streams; a topic appears once for each of its timestamp sources."""
        return [topic for topic, _ in self._streams]

    def get(self, topic: str, timestamp: str = "") -> Stream:
        """Return the stream of a topic; create it if it is missing.

        :param timestamp: name of the timestamp source; see :func:`.timestamp_source.path_of`
        """
        if (topic, timestamp) not in self._streams:
            made = self._streams[topic, timestamp] = Stream(topic, timestamp, self.clocks)
            if not timestamp and topic in self._leaders:
                made.follow(self.get(self._leaders[topic]))
        return self._streams[topic, timestamp]

    def keep(self, sinks: Collection[MessageSink]) -> None:
        """Drop all other sinks, and streams that are no longer needed."""
        for stream in self:
            stream.sinks = [sink for sink in stream.sinks if sink in sinks]
        used = {stream for stream in self if stream.sinks}
        used.update(stream.leader for stream in list(used) if stream.leader is not None)
        self._streams = {key: stream for key, stream in self._streams.items() if stream in used}

    def restart(self) -> None:
        """Drop all streams and clocks, but not the choices of clocks."""
        self._streams, self.clocks = {}, Clocks()

    def clock_topics(self) -> List[str]:
        """Return a topic of each estimated clock except the scope's: the first by name."""
        found: Dict[Clock, str] = {}
        for (topic, timestamp), stream in sorted(self._streams.items()):
            clock = stream.present_clock()
            if not timestamp and stream.path and not (stream.leader or clock.is_scope):
                found.setdefault(clock, topic)
        return list(found.values())

    def choose_clock(self, topic: str, leader: str) -> None:
        """Place the messages of a topic by the clock of another topic.

        :param topic: a recorded topic
        :param leader: one of :meth:`clock_topics`; empty to estimate the clock of the topic
        :raises FieldError: if a topic does not have a clock
        """
        stream: Optional[Stream] = self._streams.get((topic, ""))
        if stream is None or stream.path is None:
            raise FieldError(f"{topic} has no timestamps whose clock can be chosen")
        known = [one for one in self.clock_topics() if one != topic]
        if leader and leader not in known:
            others = ", ".join(known) or "none"
            raise FieldError(f"{leader} has no separate clock; topics with one: {others}")
        followers = [one for one, other in self._leaders.items() if other == topic]
        if leader and followers:
            raise FieldError(f"{topic} cannot follow another topic: {followers[0]} follows it")
        self._leaders.pop(topic, None)
        if leader:
            self._leaders[topic] = leader
        stream.follow(self._streams[leader, ""] if leader else None)
