"""The way to a subscriber: a receiver that rospy has connected, and whose losses are logged."""

import contextlib
import socket
from typing import Any, ContextManager

import rospy
from rospy.impl.tcpros_base import TCPROSTransport

from nodekit.transport.link import Link


class SubscriberLink(Link):
    """A subscriber's connection.

    :param transport: rospy's object for it
    :param lock: the topic's lock
    :param topic: the topic's name, for reports
    """

    def __init__(self, transport: TCPROSTransport, lock: ContextManager[Any], topic: str) -> None:
        super().__init__(transport.endpoint_id, transport.socket, lock)
        self._transport = transport
        self._header_bytes = transport.stat_bytes
        self._topic = topic
        # Or else TCP holds small messages back, by up to 40 ms, where the subscriber did not ask.
        with contextlib.suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def tell_rospy(self) -> None:
        """Note in rospy's object what has been sent."""
        self._transport.stat_bytes = self._header_bytes + self.sent_bytes
        self._transport.stat_num_msg = self.sent

    def close(self) -> None:
        self._transport.close()

    def report(self, stalled: bool, lost: int) -> None:
        if rospy.is_shutdown():
            return
        what = (self._topic, self.name, lost, self.lost)
        if stalled:
            rospy.logwarn("%s: subscriber %s does not keep up: %d messages lost, %d in all", *what)
        else:
            rospy.loginfo("%s: subscriber %s keeps up again: %d more lost, %d in all", *what)
