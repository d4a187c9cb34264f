"""Offers of shared memory in the headers of connections between nodes.

A subscriber adds a field to its header; publishers ignore unknown fields, as TCPROS requires. So
nothing changes for other nodes, and a connection has the same messages in the same order with and
without shared memory.
"""

import contextlib
import weakref
from typing import Any, Dict, Optional

from nodekit.process_context import PROCESS
from nodekit.shared_memory.channel import FIELD, ChannelListener, Offer, parse_offer

#: Name of the transport in ``getBusInfo``.
TRANSPORT = "SHAREDMEM"


class _State:
    """Shared memory of this process.

    :ivar offers: offers of subscribers, by the sockets of their connections
    """

    def __init__(self) -> None:
        self.is_enabled = True
        self.offers: "weakref.WeakKeyDictionary[Any, Offer]" = weakref.WeakKeyDictionary()


def disable() -> None:
    """Send and receive by TCP only, over connections that are opened from now on."""
    PROCESS.get(_State).is_enabled = False


def listener() -> Optional[ChannelListener]:
    """Return the socket on which publishers open channels; None without shared memory."""
    if PROCESS.get(_State).is_enabled:
        with contextlib.suppress(OSError):
            return PROCESS.get(ChannelListener)
    return None


def remember(sock: Any, header: Dict[str, str]) -> None:
    """Keep the offer of a new subscriber.

    :param sock: socket of its connection
    :param header: header of its connection
    """
    state = PROCESS.get(_State)
    offer = parse_offer(header.get(FIELD, "")) if state.is_enabled else None
    if offer is not None:
        state.offers[sock] = offer


def offer_of(sock: Any) -> Optional[Offer]:
    """Return the offer of a subscriber, once; None without one.

    :param sock: socket of its connection
    """
    return PROCESS.get(_State).offers.pop(sock, None)


def name_transport(connection: Any) -> None:
    """Name shared memory in ``getBusInfo``.

    :param connection: rospy's object for the connection
    """
    connection.transport_type = TRANSPORT
