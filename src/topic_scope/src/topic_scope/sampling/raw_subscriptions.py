"""Subscriptions that queue serialized messages, so that connection threads never wait."""

import sys
import threading
import time
from array import array
from typing import Any, Collection, Dict, List, Mapping

import rospy

from nodekit import Subscription, Throttle
from topic_scope.sampling.message_source import TICK_NS, Batch
from topic_scope.timing.nanoseconds import NS

#: Most bytes of queued messages of a topic; further messages are lost, with a
#: warning.
WAITING = 32 * 1024 * 1024
_WARN_EVERY_S = 10.0
_REFUSED_EVERY_S = 60.0
_READINGS = 5


class SteadyClock:
    """Clock of seconds since the epoch that never steps, even if the system clock is set."""

    def __init__(self) -> None:
        # A delay between the two readings makes the difference smaller, never larger.
        self._offset = max(time.time_ns() - time.monotonic_ns() for _ in range(_READINGS))

    def now(self) -> float:
        """Return the time [s]."""
        return self.now_ns() / NS

    def now_ns(self) -> int:
        """Return the time [ns]."""
        return self._offset + time.monotonic_ns()


class RawSubscription:
    """Subscription that queues the serialized messages of one topic.

    :param topic: its name
    :param clock: clock of the times of receipt
    """

    def __init__(self, topic: str, clock: SteadyClock) -> None:
        self.topic = topic
        self._clock = clock
        self._lock = threading.Lock()
        #: Serialized: message and time objects would take three times the memory.
        self._waiting: List[Batch] = []
        self._bytes = 0
        self._throttle = Throttle(_WARN_EVERY_S)
        self._latest = 0
        self._subscription = Subscription(topic, rospy.AnyMsg, self._on_messages)
        self._subscription.open()
        self._subscription.receive_latched()  # the process may already subscribe to the topic

    def _on_messages(self, messages: List[Any], _may_wait: bool) -> None:
        # The time is read under the lock: messages after drain() are never older than that.
        with self._lock:
            for message in messages:
                if self._bytes > WAITING:
                    if self._throttle.is_due():
                        rospy.logwarn("%s is too fast: messages are lost", self.topic)
                    return
                header = message._connection_header
                if not self._waiting or self._waiting[-1].header is not header:
                    self._waiting.append(Batch(header, array("q"), []))
                self._latest = max(self._clock.now_ns(), self._latest + TICK_NS)
                self._waiting[-1].times.append(self._latest)
                self._waiting[-1].messages.append(message._buff)
                self._bytes += sys.getsizeof(message._buff)

    def drain(self) -> List[Batch]:
        """Return the messages since the last call, oldest first."""
        with self._lock:
            waiting, self._waiting, self._bytes = self._waiting, [], 0
        return waiting

    def close(self) -> None:
        """Unsubscribe."""
        self._subscription.close()


class RawSubscriptions:
    """Subscriptions of a node that queue serialized messages; a MessageSource.

    :param clock: clock of the times of receipt
    """

    def __init__(self, clock: SteadyClock) -> None:
        self.clock = clock
        self._wanted: Collection[str] = ()
        self._open: Dict[str, RawSubscription] = {}
        self._throttle = Throttle(_REFUSED_EVERY_S)

    @property
    def has_ended(self) -> bool:
        """False: a live graph may always send more."""
        return False

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Subscribe to these topics with the next :meth:`adjust`; see :class:`.MessageSource`."""
        self._wanted = topics

    def adjust(self) -> None:
        """Subscribe and unsubscribe; may wait for the master."""
        wanted = set(self._wanted)
        for topic in wanted - set(self._open):
            try:
                made = RawSubscription(topic, self.clock)
            except (
                rospy.ROSException
            ) as error:  # e.g. for /clock, to which rospy subscribes in simulated time
                if self._throttle.is_due(topic):
                    rospy.logwarn("no samples: %s", error)
                continue
            self._open = {**self._open, topic: made}
        for topic in set(self._open) - wanted:
            self._open[topic].close()
            self._open = {key: one for key, one in self._open.items() if key != topic}

    @property
    def is_to_adjust(self) -> bool:
        """Whether the open subscriptions differ from the requested ones."""
        return set(self._wanted) != set(self._open)

    def subscriptions(self) -> Mapping[str, RawSubscription]:
        """Return the open subscriptions, by topic."""
        return self._open
