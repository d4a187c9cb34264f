"""Counters of a board's traffic and faults."""

import threading
from typing import Counter, Dict

#: Frames and bytes either way, and messages that are left out: for they do not fit into the board's
#: buffer, come while there is no contact, are of no topic that is known, or are malformed though
#: their sums hold; and times that the port was opened, and the board asked for its topics.
RECEIVED, RECEIVED_BYTES, SENT, SENT_BYTES = "received", "received bytes", "sent", "sent bytes"
TOO_LARGE, NO_CONTACT, UNKNOWN_ID = "too large", "no contact", "unknown id"
MALFORMED, REFUSED = "malformed", "of refused topics"
STUCK, OPENINGS, ASKED = "stuck", "openings", "asked"


class Counters:
    """Counts by name, for several threads at once."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    def add(self, name: str, count: int = 1) -> None:
        """Count something.

        :param name: what
        :param count: how many
        """
        with self._lock:
            self._counts[name] += count

    def to_dict(self) -> Dict[str, int]:
        """Return all counts by name."""
        with self._lock:
            return dict(self._counts)
