"""Recorder of a topic's messages, which tests wait for."""

import threading
from typing import Any, Callable, List

import rospy

from nodekit.deprecated import OldMethod
from nodekit.rospy_internals.latched import subscribe_without_loss
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class MessageRecorder:
    """Records all messages of a topic from its creation on.

    :param topic: name of the topic
    :param message_type: its message class
    """

    def __init__(self, topic: str, message_type: Any) -> None:
        self._topic = topic
        self._lock = threading.Lock()
        self._messages: List[Any] = []
        self._subscriber = subscribe_without_loss(
            rospy.resolve_name(topic), message_type, self._record
        )

    def messages(self) -> List[Any]:
        """Return the messages so far, oldest first."""
        with self._lock:
            return list(self._messages)

    def count(self) -> int:
        """Return the number of messages so far."""
        with self._lock:
            return len(self._messages)

    def publishers(self) -> int:
        """Return the number of connected publishers."""
        return int(self._subscriber.get_num_connections())

    def clear(self) -> None:
        """Delete the messages so far."""
        with self._lock:
            self._messages.clear()

    forget = OldMethod("clear")

    def wait_for(self, condition: Callable[[Any], bool], timeout: float = TIMEOUT_S) -> Any:
        """Return the first message that meets a condition; wait for it if necessary.

        :param condition: called with each message
        :param timeout: longest wait [s]
        :raises AssertionError: if no message meets it in time; the text shows the latest messages
        """
        return wait_until(
            lambda: [message for message in self.messages() if condition(message)][:1],
            lambda: f"received on {self._topic}: {self.messages()[-3:]}",
            timeout,
        )[0]

    def close(self) -> None:
        """Unsubscribe."""
        self._subscriber.unregister()

    def _record(self, message: Any) -> None:
        with self._lock:
            self._messages.append(message)
