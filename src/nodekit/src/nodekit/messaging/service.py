"""Services that end when they are closed, their clients' connections with them."""

from typing import Any, Callable, Optional

from nodekit.messaging.failures import Failures
from nodekit.rospy_internals.services import ClosableService


class Service:
    """A service of a node.

    :param name: name, resolved
    :param service_class: its type
    :param handler: returns the answer to a request, or raises what the client is told; called from
        a thread for each call
    """

    def __init__(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        self.resolved_name = name
        self._service_class, self._handler = service_class, handler
        self._service: Optional[ClosableService] = None
        self._failures = Failures()
        self._is_closed = False

    def open(self) -> None:
        """Offer it, unless it was closed."""
        if self._is_closed:
            return
        self._service = ClosableService(
            self.resolved_name, self._service_class, self._handler, error_handler=self._on_error
        )

    def _on_error(self, *_: Any) -> None:
        """Log what went wrong; mostly an answer that its type cannot hold."""
        self._failures.note(f"service {self.resolved_name}")

    def close(self) -> None:
        """Offer it no longer."""
        self._is_closed = True
        service, self._service = self._service, None
        if service is not None:
            service.shutdown()
