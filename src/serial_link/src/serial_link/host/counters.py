"""Counters of a board's traffic and faults."""

import threading
from typing import Counter, Dict

#: Frames and bytes in both directions.
RECEIVED, RECEIVED_BYTES, SENT, SENT_BYTES = "received", "received bytes", "sent", "sent bytes"
#: Dropped messages: too large for the board's buffer, sent while not synchronized, of an unknown
#: topic id, malformed despite valid checksums, or of a topic that cannot be opened in ROS.
TOO_LARGE, NO_CONTACT, UNKNOWN_ID = "too large", "no contact", "unknown id"
MALFORMED, REFUSED = "malformed", "of refused topics"
#: Frames that the port did not accept in time, openings of the port, and topic requests.
STUCK, OPENINGS, ASKED = "stuck", "openings", "asked"


class Counters:
    """Thread-safe counters by name."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    def add(self, name: str, count: int = 1) -> None:
        """Increase a counter.

        :param name: of the counter
        :param count: increment
        """
        with self._lock:
            self._counts[name] += count

    def to_dict(self) -> Dict[str, int]:
        """Return all counters by name."""
        with self._lock:
            return dict(self._counts)
