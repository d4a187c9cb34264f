"""Observer of a topic that stamps each message."""

import socket
import struct
import time
from typing import Callable, List, Tuple

from .record import Sample
from .tcpros import Node, split_messages

#: Layout of a message from its start, and the number of its value, by type.
VALUES = {
    "std_msgs/Float32": ("<f", 0),
    "basic_comms/signal_msg": ("<ffdf", 3),
    "pid_control/motor_input": ("<fd", 1),
}


class Recorder:
    """Keeps each message of one topic with the moment of its arrival.

    Its thread waits in the kernel for each message: no queue or second thread adds to the latency.

    :param node: subscribes to the topic
    :param topic: global name
    :param type_name: its type
    """

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        self._type = type_name
        #: moment [s] and what was received then
        self._chunks: List[Tuple[float, bytes]] = []
        node.subscribe(topic, type_name, self._record)

    def _record(self, connection: socket.socket) -> None:
        receive, now, keep = connection.recv, time.monotonic, self._chunks.append
        data = b"-"
        while data:
            data = receive(65536)
            keep((now(), data))

    def messages(self, start: int = 0) -> List[Tuple[float, bytes]]:
        """Return the messages, each with its moment [s].

        :param start: the first chunk; each message must be within one chunk
        """
        found = []
        rest = b""
        for moment, data in self._chunks[start:]:
            whole, rest = split_messages(rest + data)
            found += [(moment, message) for message in whole]
        return found

    def samples(self) -> List[Sample]:
        """Return moment and value of each message."""
        layout, field = VALUES[self._type]
        return [
            Sample(moment, struct.unpack_from(layout, message)[field])
            for moment, message in self.messages()
        ]

    def latest(self) -> bytes:
        """Return the last message; empty before the first one."""
        messages = self.messages(max(0, len(self._chunks) - 1))
        return messages[-1][1] if messages else b""

    def wait(self, count: int = 1, limit: float = 30.0) -> float:
        """Wait for some messages, and return the moment of the first one [s]."""
        wait_until(lambda: len(self._chunks) >= count, limit, "messages")
        return self._chunks[0][0]


def wait_until(condition: Callable[[], object], limit: float, what: str) -> None:
    """Wait for a condition.

    :param limit: longest wait [s]
    :raises TimeoutError: if the condition does not become true
    """
    give_up = time.monotonic() + limit
    while not condition():
        if time.monotonic() > give_up:
            raise TimeoutError(f"no {what} within {limit:g} s")
        time.sleep(0.01)
