"""How rospy serves: a thread for each connection, which a closed service leaves running."""

import contextlib
import socket
from typing import Any, Dict, List, Tuple

import rospy
from rospy.impl.registration import get_service_manager

from nodekit.rospy_internals.registry import NameTaken


class ClosableService(rospy.Service):
    """A ``rospy.Service`` that ends lasting connections of its clients when it is shut down.

    :raises NameTaken: if this process offers one of that name already
    """

    #: All services with such connections, and those: in most processes there are none.
    _lasting: List[Tuple["ClosableService", Any]] = []

    def __init__(self, name: str, *args: Any, **kwds: Any) -> None:
        try:
            super().__init__(name, *args, **kwds)
        except rospy.ServiceException:
            raise NameTaken(f"service {name}: refused: this process offers it already") from None

    def handle(self, transport: Any, header: Dict[str, str]) -> None:
        """Serve a client until it or the service has ended.

        :param transport: rospy's object for the connection
        :param header: what the client said of itself
        """
        if header.get("persistent", "").lower() not in ("1", "true"):
            super().handle(transport, header)  # which ends by itself after one call
            return
        self._lasting.append((self, transport))
        try:
            super().handle(transport, header)
        finally:
            self._lasting.remove((self, transport))

    def shutdown(self, reason: str = "") -> None:
        """End the service; the client of a call that is under way still gets its answer.

        :param reason: as rospy has it; without effect
        """
        self.done = True
        with contextlib.suppress(KeyError):  # rospy's own end empties the table without its lock
            get_service_manager().unregister(self.resolved_name, self)
        for service, transport in list(self._lasting):
            if service is self:
                with contextlib.suppress(OSError, AttributeError):  # it has just ended
                    transport.socket.shutdown(socket.SHUT_RD)
