"""Hear what is said on a topic, and wait for what should be said."""

import threading
from typing import Any, Callable, List

import rospy

from nodekit.rospy_internals.latched import subscribe_heard
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class Ear:
    """All messages of one topic, from the moment this object is made."""

    def __init__(self, topic: str, message_type: Any) -> None:
        self._topic = topic
        self._lock = threading.Lock()
        self._heard: List[Any] = []
        self._subscriber = subscribe_heard(rospy.resolve_name(topic), message_type, self._hear)

    def messages(self) -> List[Any]:
        """Return what has been heard so far, oldest first."""
        with self._lock:
            return list(self._heard)

    def count(self) -> int:
        """Return how many messages have been heard so far."""
        with self._lock:
            return len(self._heard)

    def publishers(self) -> int:
        """Return how many publishers are connected."""
        return int(self._subscriber.get_num_connections())

    def forget(self) -> None:
        """Start over."""
        with self._lock:
            self._heard.clear()

    def wait_for(self, condition: Callable[[Any], bool], timeout: float = TIMEOUT_S) -> Any:
        """Return the first message that meets a condition, heard already or yet to come.

        :raises AssertionError: when none does in time; the text shows the latest messages
        """
        return wait_until(
            lambda: [message for message in self.messages() if condition(message)][:1],
            lambda: f"received on {self._topic}: {self.messages()[-3:]}",
            timeout,
        )[0]

    def close(self) -> None:
        """Stop listening."""
        self._subscriber.unregister()

    def _hear(self, message: Any) -> None:
        with self._lock:
            self._heard.append(message)
