"""Publisher's connection over a rospy transport to one subscriber, which logs lost messages."""

import contextlib
import socket
import threading
from typing import Any, ContextManager, Optional

import rospy
from rospy.impl.tcpros_base import TCPROSTransport

from nodekit.rospy_internals.shared_memory_offers import name_transport, offer_of
from nodekit.shared_memory.shared_connection import SharedConnection, TopicMemory


class RosSubscriberConnection(SharedConnection):
    """Publisher's connection over a rospy transport to one subscriber, which logs lost messages.

    :param transport: rospy's object for it
    :param lock: the topic's lock
    :param topic: the topic's name, for reports
    :param depth: as in :class:`.SubscriberConnection`
    :param memory: the topic's shared memory
    """

    def __init__(
        self,
        transport: TCPROSTransport,
        lock: ContextManager[Any],
        topic: str,
        depth: Optional[int],
        memory: TopicMemory,
    ) -> None:
        sock = transport.socket
        super().__init__(transport.endpoint_id, sock, lock, depth, memory, offer_of(sock))
        self._transport = transport
        self._header_bytes = transport.stat_bytes
        self._topic = topic
        # TCP would delay small messages by up to 40 ms if the subscriber did not set tcp_nodelay.
        with contextlib.suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def update_rospy_statistics(self) -> None:
        """Copy the counters to rospy's object."""
        self._transport.stat_bytes = self._header_bytes + self.sent_bytes
        self._transport.stat_num_msg = self.sent

    def close(self) -> None:
        self._transport.close()

    def on_shared(self) -> None:
        name_transport(self._transport)

    def on_rejected(self, why: str) -> None:
        text = "%s: large messages to %s go by TCP: %s"
        what = (text, self._topic, self.name, why)
        # The topic's lock is held: on /rosout, a thread that logs would wait for it.
        threading.Thread(target=rospy.logdebug, args=what, daemon=True).start()

    def report(self, stalled: bool, lost: int) -> None:
        if rospy.is_shutdown():
            return
        what = (self._topic, self.name, lost, self.lost)
        if stalled:
            rospy.logwarn("%s: subscriber %s does not keep up: %d messages lost, %d in all", *what)
        else:
            rospy.loginfo("%s: subscriber %s keeps up again: %d more lost, %d in all", *what)

    def report_unsent(self) -> None:
        """Report that the messages that are still held are lost, as the topic closes."""
        what = (self._topic, self.name, self.unsent_messages)
        rospy.logwarn("%s: closing; subscriber %s has not taken %d messages, which are lost", *what)
