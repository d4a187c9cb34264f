"""What watches topics: one observer that stamps each message, one that only counts."""

import selectors
import socket
import struct
import threading
import time
from typing import Callable, Dict, List, Tuple

from .analysis import Sample
from .tcpros import Node, split_messages

#: where the value stands in a message, by type: (layout from the start, which field)
VALUES = {
    "std_msgs/Float32": ("<f", 0),
    "basic_comms/signal_msg": ("<ffdf", 3),
    "pid_control/motor_input": ("<fd", 1),
}


class Recorder:
    """Keeps each message of one topic with the moment it was received.

    It waits in the kernel for each message: no queue or second thread adds to the latency.

    :param node: on whose behalf
    :param topic: global name
    :param type_name: a key of :data:`VALUES`
    """

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        self._type = type_name
        #: (moment in s, what was received then)
        self._chunks: List[Tuple[float, bytes]] = []
        node.subscribe(topic, type_name, self._start)

    def _start(self, connection: socket.socket) -> None:
        threading.Thread(target=self._record, args=(connection,), daemon=True).start()

    def _record(self, connection: socket.socket) -> None:
        receive, now, keep = connection.recv, time.monotonic, self._chunks.append
        try:
            while True:
                data = receive(65536)
                keep((now(), data))
                if not data:
                    return
        except OSError:
            return  # closed by this side

    def messages(self, start: int = 0) -> List[Tuple[float, bytes]]:
        """Return the messages, each with its moment in s.

        :param start: from which chunk on; each message must be within one chunk
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
        """Wait for so many messages.

        :returns: the moment of the first message, s
        """
        wait_until(lambda: len(self._chunks) >= count, limit, "messages")
        return self._chunks[0][0]


class Counter:
    """Counts the messages of any number of topics at little cost, by their bytes.

    It looks once every few milliseconds: what it measures is rates, not moments.

    :param node: on whose behalf
    """

    PERIOD = 0.005

    def __init__(self, node: Node) -> None:
        self._node = node
        self._selector = selectors.DefaultSelector()
        self._bytes: Dict[str, int] = {}
        self._sizes: Dict[str, int] = {}
        #: when the first message of each topic was seen, s
        self.first: Dict[str, float] = {}
        threading.Thread(target=self._read, daemon=True).start()

    def watch(self, topic: str, type_name: str) -> None:
        """Count a topic's messages from now on."""
        self._bytes[topic] = 0
        self._sizes[topic] = 4 + struct.calcsize(VALUES[type_name][0])
        self._node.subscribe(
            topic,
            type_name,
            lambda connection: self._add(topic, connection),
        )

    def counts(self) -> Dict[str, int]:
        """Return how many messages of each topic have been received."""
        return {topic: size // self._sizes[topic] for topic, size in self._bytes.items()}

    def _add(self, topic: str, connection: socket.socket) -> None:
        connection.setblocking(False)
        self._selector.register(connection, selectors.EVENT_READ, topic)

    def _read(self) -> None:
        while True:
            ready = self._selector.select(timeout=0.1)
            for key, _ in ready:
                connection: socket.socket = key.fileobj  # type: ignore[assignment]
                try:
                    data = connection.recv(1 << 20)
                except BlockingIOError:
                    continue
                except OSError:
                    data = b""
                if not data:
                    self._selector.unregister(connection)
                    continue
                self.first.setdefault(key.data, time.monotonic())
                self._bytes[key.data] += len(data)
            time.sleep(self.PERIOD)


def wait_until(condition: Callable[[], bool], limit: float, what: str) -> None:
    """Wait for a condition.

    :param limit: for how long at most, s
    :raises TimeoutError: if it does not come true
    """
    give_up = time.monotonic() + limit
    while not condition():
        if time.monotonic() > give_up:
            raise TimeoutError(f"no {what} within {limit:g} s")
        time.sleep(0.002)
