"""Services that end when they are closed, their clients' connections with them."""

from typing import Any, Callable, Optional

from nodekit.messaging.callback_errors import CallbackErrors
from nodekit.rospy_internals.closable_service import ClosableService
from nodekit.rospy_internals.registry import name_before_remapping


class _LoggedService(ClosableService):
    """Logs what goes wrong; mostly an answer that its type cannot hold."""

    _failures: Optional[CallbackErrors] = None  # made for the first one: hardly any service has one

    def error_handler(self, *_: Any) -> None:
        """Log the exception that is being handled; rospy calls this."""
        self._failures = self._failures or CallbackErrors()
        self._failures.record(f"service {self.resolved_name}")


class Service:
    """A service of a node.

    :param name: name, resolved
    :param service_class: its type
    :param handler: returns the answer to a request, or raises what the client is told; called from
        a thread for each call
    """

    __slots__ = ("resolved_name", "_service_class", "_handler", "_service", "_is_closed")

    def __init__(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        self.resolved_name = name
        self._service_class, self._handler = service_class, handler
        self._service: Optional[ClosableService] = None
        self._is_closed = False

    def open(self) -> None:
        """Offer it, unless it was closed."""
        if self._is_closed:
            return
        name = name_before_remapping(self.resolved_name)
        service = _LoggedService(name, self._service_class, self._handler)
        self._service = service
        self.resolved_name = service.resolved_name  # rospy makes a copy, which is enough of them
        if self._is_closed:  # by another thread, meanwhile
            self.close()

    def close(self) -> None:
        """Offer it no longer."""
        self._is_closed = True
        service, self._service = self._service, None
        if service is not None:
            service.shutdown()
