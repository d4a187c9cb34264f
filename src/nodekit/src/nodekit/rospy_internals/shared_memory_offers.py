"""Offers of shared memory in the headers of connections between nodes.

A subscriber adds a field to its header; publishers ignore unknown fields, as TCPROS requires. So
nothing changes for other nodes, and a connection has the same messages in the same order with and
without shared memory.
"""

import contextlib
import functools
import weakref
from typing import Any, Dict, Optional

from nodekit.shared_memory.channel import FIELD, ChannelListener, Offer, parse_offer

#: Name of the transport in ``getBusInfo``.
TRANSPORT = "SHAREDMEM"

_is_enabled = True
#: Offers of subscribers, by the sockets of their connections.
_offers: "weakref.WeakKeyDictionary[Any, Offer]" = weakref.WeakKeyDictionary()


def disable() -> None:
    """Send and receive by TCP only, over connections that are opened from now on."""
    global _is_enabled
    _is_enabled = False


@functools.lru_cache(maxsize=None)
def _listener() -> ChannelListener:
    return ChannelListener()


def listener() -> Optional[ChannelListener]:
    """Return the socket on which publishers open channels; None without shared memory."""
    if _is_enabled:
        with contextlib.suppress(OSError):
            return _listener()
    return None


def remember(sock: Any, header: Dict[str, str]) -> None:
    """Keep the offer of a new subscriber.

    :param sock: socket of its connection
    :param header: header of its connection
    """
    offer = parse_offer(header.get(FIELD, "")) if _is_enabled else None
    if offer is not None:
        _offers[sock] = offer


def offer_of(sock: Any) -> Optional[Offer]:
    """Return the offer of a subscriber, once; None without one.

    :param sock: socket of its connection
    """
    return _offers.pop(sock, None)


def name_transport(connection: Any) -> None:
    """Name shared memory in ``getBusInfo``.

    :param connection: rospy's object for the connection
    """
    connection.transport_type = TRANSPORT
