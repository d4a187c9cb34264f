"""Service of a node, whose persistent connections end when it is closed."""

from typing import Any, Callable, Optional

from nodekit.messaging.callback_errors import CallbackErrors
from nodekit.rospy_internals.closable_service import ClosableService
from nodekit.rospy_internals.registry import name_before_remapping


class _LoggedService(ClosableService):
    """Service that logs errors, most often of a response that cannot be serialized."""

    _failures: Optional[CallbackErrors] = None  # created for the first error, which is rare

    def error_handler(self, *_: Any) -> None:
        """Log the current exception; rospy calls this."""
        self._failures = self._failures or CallbackErrors()
        self._failures.record(f"service {self.resolved_name}")


class Service:
    """Service of a node.

    :param name: name, resolved
    :param service_class: service type
    :param handler: returns the response to a request, or raises an error for the client; called
        from a thread for each call
    """

    __slots__ = ("resolved_name", "_service_class", "_handler", "_service", "_is_closed")

    def __init__(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        self.resolved_name = name
        self._service_class, self._handler = service_class, handler
        self._service: Optional[ClosableService] = None
        self._is_closed = False

    def open(self) -> None:
        """Offer the service, unless it is closed."""
        if self._is_closed:
            return
        name = name_before_remapping(self.resolved_name)
        service = _LoggedService(name, self._service_class, self._handler)
        self._service = service
        self.resolved_name = service.resolved_name  # share rospy's copy of the text
        if self._is_closed:  # by another thread meanwhile
            self.close()

    def close(self) -> None:
        """Stop offering the service."""
        self._is_closed = True
        service, self._service = self._service, None
        if service is not None:
            service.shutdown()
