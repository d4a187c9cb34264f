"""Node that only forwards pings to a board and its answers back; usage: serial_bare.py PORT.

It is the minimum for a node in Python: it detects no faults of the board or the cable.
"""

import os
import sys
import threading
import tty
from typing import Dict

from nodekit import Node, run
from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import encode
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, TIME, decode_topic, encode_time
from std_msgs.msg import UInt32


class Bare:
    """Node class that publishes ``pong`` and subscribes to ``ping``."""

    def __init__(self, node: Node) -> None:
        self._port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._port)
        self._ids: Dict[str, int] = {}
        self._publisher = node.create_publisher("pong", UInt32)
        node.create_subscription("ping", UInt32, self._send)
        threading.Thread(target=self._receive, daemon=True).start()
        os.write(self._port, encode(PUBLISHER, b""))

    def _send(self, ping: UInt32) -> None:
        if "ping" in self._ids:
            os.write(self._port, encode(self._ids["ping"], ping.data.to_bytes(4, "little")))

    def _receive(self) -> None:
        decoder = Decoder()
        while True:
            for topic_id, payload in decoder.feed(os.read(self._port, 4096)):
                if topic_id in (PUBLISHER, SUBSCRIBER):
                    info = decode_topic(payload)
                    self._ids[info.name] = info.topic_id
                elif topic_id == TIME:
                    os.write(self._port, encode(TIME, encode_time(0, 0)))
                elif topic_id == self._ids.get("pong"):
                    self._publisher.publish(UInt32().deserialize(payload))


if __name__ == "__main__":
    run("bare", Bare)
