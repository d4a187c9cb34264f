"""The service that a client calls: where it is, what it is sent, and what its answer means."""

import contextlib
import io
import socket
from typing import Any, Dict, NoReturn, Optional, Tuple

import genpy
import rosgraph
import rospy
from rosgraph.network import parse_http_host_and_port as host_and_port

from nodekit.master import MasterClient, MasterUnreachable
from nodekit.transport.service_call import CallFailed, ServiceCall


class CallError(rospy.ServiceException):
    """A call without an answer; the text names the service and says why."""


class CallTimeout(CallError):
    """A call that was not answered in time."""


class Server:
    """Whoever offers a service at the moment.

    :param name: of the service, resolved
    :param service_class: its type
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self.name = name
        self._class = service_class

    def serialised(self, request: Any) -> bytes:
        """Return a request as it is sent.

        :param request: of the service's request class
        :raises CallError: if it is none, or holds what its fields cannot
        """
        expected = self._class._request_class
        if not isinstance(request, expected):
            self._refuse(f"refused {request!r}: must be a {expected.__name__}")
        buffer = io.BytesIO()
        try:
            request.serialize(buffer)
        except genpy.SerializationError as error:
            self._refuse(f"its request is refused: {error}")
        return buffer.getvalue()

    def _refuse(self, why: str) -> NoReturn:
        raise CallError(f"{self.name} is not called: {why}") from None

    def answer(self, call: ServiceCall, request: bytes) -> Any:
        """Send a request and wait for the answer.

        :param call: how, and how long
        :param request: from :meth:`serialised`
        :raises CallError: if there is no answer
        """
        header = {"md5sum": self._class._md5sum, "type": self._class._type}
        try:
            return self._class._response_class().deserialize(self._send(call, header, request))
        except genpy.DeserializationError as error:
            raise CallError(f"{self.name} answers what makes no sense: {error}") from None

    def look(self, call: ServiceCall) -> None:
        """Look whether it could answer.

        :param call: how, and how long
        :raises CallError: if it could not
        """
        self._send(call, {"md5sum": "*", "probe": "1"}, None)

    def _send(self, call: ServiceCall, header: Dict[str, str], request: Optional[bytes]) -> bytes:
        header = {"callerid": rospy.get_name(), "service": self.name, **header}
        try:
            return call.run(self._address(call.left()), header, request)
        except CallFailed as error:
            raise CallError(f"{self.name} answers with an error: {error}") from None
        except socket.timeout:
            raise CallTimeout(f"{self.name}: no answer within {call.timeout:g} s") from None
        except (OSError, MasterUnreachable) as error:
            raise CallError(f"{self.name} cannot be called: {error}") from None

    def _address(self, timeout: float) -> Tuple[str, int]:
        uri, name = rosgraph.get_master_uri(), rospy.get_name()
        with contextlib.closing(MasterClient(uri, name, "", timeout)) as master:
            found = master.lookup_service(self.name)
        if found is None:
            raise ConnectionError("nobody offers it")
        try:
            host, port = host_and_port(found.replace("rosrpc://", "http://", 1))
            host.encode("idna")  # as connecting to it does
        except ValueError as error:
            raise ConnectionError(f"it is offered at {found!r}: {error}") from None
        return host, port
