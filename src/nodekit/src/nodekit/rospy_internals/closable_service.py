"""Service that ends its persistent connections on shutdown; rospy would keep them open."""

import contextlib
import socket
from typing import Any, Dict, List

import rospy
from rospy.impl.registration import get_service_manager

from nodekit.rospy_internals.registry import NameTaken


class ClosableService(rospy.Service):
    """``rospy.Service`` that closes persistent connections when it is shut down.

    :raises NameTaken: if this process offers a service of that name already
    """

    def __init__(self, name: str, *args: Any, **kwds: Any) -> None:
        self._persistent: List[Any] = []  # connections; rospy serves some before its method ends
        try:
            super().__init__(name, *args, **kwds)
        except rospy.ServiceException:
            raise NameTaken(f"service {name}: refused: this process offers it already") from None

    def handle(self, transport: Any, header: Dict[str, str]) -> None:
        """Serve a client until its connection or the service ends.

        :param transport: rospy's object for the connection
        :param header: the client's connection header
        """
        if header.get("persistent", "").lower() not in ("1", "true"):
            super().handle(transport, header)  # ends after one call
            return
        self._persistent.append(transport)
        try:
            super().handle(transport, header)
        finally:
            self._persistent.remove(transport)

    def shutdown(self, reason: str = "") -> None:
        """End the service; a running call still gets its response.

        :param reason: ignored; rospy's parameter
        """
        self.done = True
        with contextlib.suppress(KeyError):  # rospy's shutdown empties the table without its lock
            get_service_manager().unregister(self.resolved_name, self)
        for transport in list(self._persistent):
            with contextlib.suppress(OSError, AttributeError):  # it has just been closed
                transport.socket.shutdown(socket.SHUT_RD)
