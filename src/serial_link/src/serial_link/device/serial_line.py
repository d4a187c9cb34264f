"""Simulated serial line between a simulated board and its port, with a baud rate and noise."""

import math
import random
from collections import deque
from typing import Deque

#: Bits on the line for a byte.
_BITS = 10


class SerialLine:
    """Serial line at a baud rate. Time is an argument [s].

    :param baud: bits per second; 0 for a line without delay
    """

    def __init__(self, baud: int) -> None:
        self._byte = _BITS / baud if baud else 0.0
        self._chunks: Deque["_Chunk"] = deque()
        self._free_at = 0.0
        #: Number of bytes that have not arrived yet.
        self.waiting = 0

    def put(self, now: float, data: bytes) -> None:
        """Start to send bytes, after those in transit.

        :param now: the time [s]
        :param data: the bytes
        """
        if data:
            begin = max(now, self._free_at)
            self._free_at = begin + len(data) * self._byte
            self._chunks.append(_Chunk(data, begin))
            self.waiting += len(data)

    def arrived(self, now: float) -> bytes:
        """Take the bytes that have arrived.

        :param now: the time [s]
        """
        arrived = bytearray()
        while self._chunks:
            chunk = self._chunks[0]
            left = len(chunk.data) - chunk.taken
            count = left
            if self._byte:
                count = min(left, int((now - chunk.begin) / self._byte + 1e-6) - chunk.taken)
            if count <= 0:
                break
            arrived += chunk.data[chunk.taken : chunk.taken + count]
            chunk.taken += count
            if chunk.taken < len(chunk.data):
                break
            self._chunks.popleft()
        self.waiting -= len(arrived)
        return bytes(arrived)

    def next_due(self) -> float:
        """Return when the first chunk in transit has arrived completely [s]."""
        if not self._chunks:
            return math.inf
        chunk = self._chunks[0]
        return chunk.begin + len(chunk.data) * self._byte

    def clear(self) -> None:
        """Drop all bytes in transit, as when the cable is unplugged."""
        self._chunks.clear()
        self._free_at, self.waiting = 0.0, 0


class _Chunk:
    """Bytes that were written together.

    :ivar taken: number of them already delivered
    """

    __slots__ = ("data", "begin", "taken")

    def __init__(self, data: bytes, begin: float) -> None:
        self.data, self.begin, self.taken = data, begin, 0


def add_noise(data: bytes, rate: float, source: random.Random) -> bytes:
    """Return bytes as a bad cable delivers them: some changed, some lost, some doubled.

    :param data: the sent bytes
    :param rate: share of damaged bytes, from 0 to 1
    :param source: random generator
    """
    if rate <= 0.0:
        return data
    result = bytearray()
    for byte in data:
        if source.random() >= rate:
            result.append(byte)
            continue
        how = source.randrange(3)
        if how == 0:
            result.append(byte ^ source.randrange(1, 256))
        elif how == 1:
            result += bytes((byte, byte))
    return bytes(result)
