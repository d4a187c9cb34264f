"""Offers of shared memory in the headers of connections between nodes.

A subscriber adds a field to its header; publishers ignore unknown fields, as TCPROS requires. So
nothing changes for other nodes, and a connection has the same messages in the same order with and
without shared memory.
"""

import contextlib
import weakref
from typing import Any, Dict, Optional

from nodekit.process_context import PROCESS
from nodekit.shared_memory.channel import FIELD, ReaderChannel

#: Name of shared memory in ``getBusInfo``.
SHARED = "SHAREDMEM"


class _State:
    """Shared memory of this process.

    :ivar offers: names of subscribers' channels, by the sockets of their connections
    """

    def __init__(self) -> None:
        self.is_enabled = True
        self.offers: "weakref.WeakKeyDictionary[Any, str]" = weakref.WeakKeyDictionary()


def disable() -> None:
    """Send and receive by TCP only, over connections that are opened from now on."""
    PROCESS.get(_State).is_enabled = False


def new_channel(data_class: Any) -> Optional[ReaderChannel]:
    """Return a channel to be offered to a publisher; None without shared memory.

    Each takes a descriptor: messages without an array of any length are not large enough.

    :param data_class: class of the messages
    """
    if PROCESS.get(_State).is_enabled and (
        data_class._type == "*" or "[]" in data_class._full_text
    ):
        with contextlib.suppress(OSError):
            return ReaderChannel()
    return None


def remember(sock: Any, header: Dict[str, str]) -> None:
    """Keep the offer of a new subscriber.

    :param sock: socket of its connection
    :param header: header of its connection
    """
    if PROCESS.get(_State).is_enabled and FIELD in header:
        PROCESS.get(_State).offers[sock] = header[FIELD]


def offer_of(sock: Any) -> str:
    """Return the offer of a subscriber, once; empty without one.

    :param sock: socket of its connection
    """
    return PROCESS.get(_State).offers.pop(sock, "")


def name_transport(connection: Any, is_shared: bool = True) -> None:
    """Set the transport's name in ``getBusInfo``.

    :param connection: rospy's object for the connection
    :param is_shared: whether large messages go through shared memory
    """
    connection.transport_type = SHARED if is_shared else "TCPROS"
