"""Service clients, blocking and asynchronous, with time-outs; reject a wait that would deadlock."""

import concurrent.futures
import contextlib
import io
import math
import socket
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, NoReturn, Optional, Set, Tuple

import genpy
import rospy
from rosgraph.network import parse_http_host_and_port as host_and_port

from nodekit.argument_checks import (
    check_function,
    check_service_class,
    check_timeout,
    check_wait,
)
from nodekit.groups.callback_groups import NoGroup
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.node.callbacks import Callback, ServiceCallback
from nodekit.process_context import PROCESS
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.transport.service_call import CallFailed, ServiceCall

#: Default time-out of a call [s].
TIMEOUT_S = 5.0
#: Default time-out of a single query [s].
ANSWER_S = 2.0
#: Most calls of one client at the same time.
MOST_CALLS = 200
#: Pauses between two probes of a missing service, and between two log lines about it [s].
_PROBE_EVERY_S, _LOG_EVERY_S = 0.1, 1.0


class CallError(rospy.ServiceException):
    """Error of a call without a response; the text names the service and the reason."""


class CallTimeout(CallError):
    """Error of a call without a response in time."""


class CallCancelled(CallError):
    """Error of a call that was cancelled, or ended with its node."""


class NestedCall(CallError):
    """Error of a call that would wait for its own caller."""


class _Server:
    """Server of a service, looked up for each call.

    :param name: name of the service, resolved
    :param service_class: service class
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self.name = name
        self._class = service_class

    def serialize(self, request: Any) -> bytes:
        """Return a serialized request.

        :param request: of the service's request class
        :raises CallError: if it is of another class, or a field has an invalid value
        """
        expected = self._class._request_class
        if not isinstance(request, expected):
            self._raise_not_called(f"refused {request!r}: must be a {expected.__name__}")
        buffer = io.BytesIO()
        try:
            request.serialize(buffer)
        except genpy.SerializationError as error:
            self._raise_not_called(f"its request is refused: {error}")
        return buffer.getvalue()

    def _raise_not_called(self, why: str) -> NoReturn:
        raise CallError(f"{self.name} is not called: {why}") from None

    def request(self, call: ServiceCall, request: bytes) -> Any:
        """Send a request, and return the response.

        :param call: the connection and its time-out
        :param request: from :meth:`serialize`
        :raises CallError: if there is no response
        """
        header = {"md5sum": self._class._md5sum, "type": self._class._type}
        try:
            return self._class._response_class().deserialize(self._send(call, header, request))
        except genpy.DeserializationError as error:
            raise CallError(f"{self.name} sent a malformed reply: {error}") from None

    def probe(self, call: ServiceCall) -> Dict[str, str]:
        """Return the header of its response to a probe.

        :param call: the connection and its time-out
        :raises CallError: if it does not respond
        """
        self._send(call, {"md5sum": "*", "probe": "1"}, None)
        return call.said

    def _send(self, call: ServiceCall, header: Dict[str, str], request: Optional[bytes]) -> bytes:
        header = {"callerid": rospy.get_name(), "service": self.name, **header}
        try:
            return call.run(self._address(call.left()), header, request)
        except CallFailed as error:
            raise CallError(f"{self.name} replied with an error: {error}") from None
        except (OSError, MasterUnreachable) as error:
            # The master may have used up the time.
            if isinstance(error, socket.timeout) or time.monotonic() >= call.deadline:
                raise CallTimeout(f"{self.name}: no answer within {call.timeout:g} s") from None
            raise CallError(f"{self.name} cannot be called: {error}") from None

    def _address(self, timeout: float) -> Tuple[str, int]:
        with MasterClient(rospy.get_name(), timeout=timeout) as master:
            found = master.lookup_service(self.name)
        if found is None:
            raise ConnectionError("no node offers it")
        try:
            host, port = host_and_port(found.replace("rosrpc://", "http://", 1))
            host.encode("idna")  # the error that connecting would raise
        except ValueError as error:
            raise ConnectionError(f"it is offered at {found!r}: {error}") from None
        return host, port


class CallFuture(concurrent.futures.Future):
    """Future response to a call, which is done by the deadline.

    :param client: the client that makes the call
    :param timeout: time-out of the call [s]
    """

    def __init__(self, client: "Client", timeout: float) -> None:
        super().__init__()
        self._client = client
        self._call = ServiceCall(timeout)

    def result(self, timeout: Optional[float] = None) -> Any:
        """Wait for the response.

        :param timeout: longest wait [s]; at most, and by default, up to the call's own deadline
        :raises CallTimeout: if there is no response in time
        :raises CallCancelled: if the call was cancelled
        :raises NestedCall: if the server waits for the calling thread
        :raises CallError: if the service is missing, or replied with an error
        """
        if not self.done():
            self._client.reject_nested()
        left = max(0.0, self._call.deadline - time.monotonic())
        wait = left if timeout is None else min(timeout, left)
        try:
            return super().result(wait)
        except concurrent.futures.CancelledError:
            raise CallCancelled(f"the call of {self._client.name} was cancelled") from None
        except concurrent.futures.TimeoutError:
            waited = self._call.timeout if wait == left else wait
            raise CallTimeout(f"{self._client.name}: no answer within {waited:g} s") from None

    def cancel(self) -> bool:
        """Cancel the call; the server notices only if it checks the connection.

        :returns: whether it was cancelled; False if it is done
        """
        is_cancelled = super().cancel()
        self._call.cancel()
        return is_cancelled

    def add_done_callback(self, function: Callable[["CallFuture"], Any]) -> None:
        """Call a function with this future when it is done, in the client's callback group.

        :param function: the function
        :raises TypeError: if it is not callable, or async
        """
        check_function(function, f"{self._client.name}: add_done_callback", 1)
        super().add_done_callback(
            lambda _: self._client.done.offer(partial(self._call_back, function))
        )

    def _call_back(self, function: Callable[["CallFuture"], Any]) -> None:
        self._client.done.call_inside(function, self)

    def run(self, request: bytes) -> None:
        """Make the call; runs in its own thread.

        :param request: serialized request
        """
        try:
            response, error = self._client.server.request(self._call, request), None
        except Exception as failure:  # of any type: result() raises it
            response, error = None, failure
        with contextlib.suppress(concurrent.futures.InvalidStateError):  # cancelled
            if error is None:
                self.set_result(response)
            else:
                self.set_exception(error)
        self._client.running_calls.discard(self)


def client_names() -> Set[str]:
    """Return the names of the services that this process has clients of."""
    return {client.name for client in list(PROCESS.instances(Client))}


class Client:
    """Client of one service; each call has its own connection, so responses are never swapped.

    :param name: name of the service, resolved
    :param service_class: service class
    :param done: callback for calls that are done
    :raises TypeError: if the class is not a service class
    """

    def __init__(self, name: str, service_class: Any, done: Callback) -> None:
        check_service_class(service_class, name)
        self.name, self.done = name, done
        self.server = _Server(name, service_class)
        self.running_calls: Set[CallFuture] = set()
        self._is_closed = False
        PROCESS.instances(Client).add(self)

    def call(self, request: Any, timeout: float = TIMEOUT_S) -> Any:
        """Call the service, and wait for the response.

        :param request: of the service's request class
        :param timeout: longest wait [s]
        :returns: the response
        :raises CallError: if there is no response, see :meth:`CallFuture.result`
        """
        self.reject_nested()
        return self.call_async(request, timeout).result()

    def call_async(self, request: Any, timeout: float = TIMEOUT_S) -> CallFuture:
        """Call the service without waiting.

        :param request: of the service's request class
        :param timeout: longest time to the response [s]
        :returns: the future response
        :raises CallError: if the request cannot be sent, or too many calls are running
        :raises ValueError: if the time-out is invalid
        """
        check_timeout(timeout)
        if self._is_closed or rospy.is_shutdown():
            raise CallCancelled(f"{self.name} is not called: its client is closed")
        if len(self.running_calls) >= MOST_CALLS:
            raise CallError(f"{self.name} is not called: {MOST_CALLS} calls are running already")
        content = self.server.serialize(request)
        future = CallFuture(self, timeout)
        self.running_calls.add(future)
        threading.Thread(
            target=future.run, args=(content,), name=f"call of {self.name}", daemon=True
        ).start()
        return future

    def wait_for_service(self, timeout: float = math.inf) -> bool:
        """Wait until the service is available; log each second why it is not.

        :param timeout: longest wait [s]; by default until the node ends. With 0 the service is
            probed once, which takes up to 0.1 s if the server does not respond
        :returns: whether the service is available
        :raises ValueError: if the time-out is not a number
        """
        check_wait(timeout)
        began = logged = time.monotonic()
        while not (self._is_closed or rospy.is_shutdown()):
            left = began + timeout - time.monotonic()
            try:
                self.server.probe(ServiceCall(min(max(left, _PROBE_EVERY_S), _LOG_EVERY_S)))
                return True
            except CallError as error:
                reason = error
            if time.monotonic() >= logged + _LOG_EVERY_S:
                logged = time.monotonic()
                rospy.loginfo("%s; waiting again...", reason)
            if left <= 0.0:
                break
            time.sleep(min(_PROBE_EVERY_S, max(0.0, left)))
        return False

    def close(self) -> None:
        """Cancel all running calls, and make no others."""
        self._is_closed = True
        for future in list(self.running_calls):
            future.cancel()

    def reject_nested(self) -> None:
        """Reject a call of a service in this process that waits for the calling thread.

        :raises NestedCall: if the service does
        """
        callback = PROCESS.by_name(ServiceCallback).get(self.name)
        if callback is not None and callback.waits_for_caller():
            raise NestedCall(
                f"{self.name} is not called: it is answered in the callback group or by the thread"
                " that would wait for it; give the service its own group, or call it"
                " asynchronously"
            )


def call_service(
    name: str, service_class: Any, *fields: Any, timeout: float = ANSWER_S
) -> CallFuture:
    """Call a service once, without a node's class, for commands and tools.

    :param name: global name of the service
    :param service_class: service class
    :param fields: fields of the request, in their order
    :param timeout: longest time to the response [s]
    :returns: the future response
    :raises CallError: if the request cannot be sent
    :raises ValueError: if the time-out is invalid
    """
    done = Callback(NoGroup(), lambda function, future: function(future), name)
    client = Client(name, service_class, done)
    return client.call_async(service_class._request_class(*fields), timeout)


def probe_service(name: str, timeout: float = ANSWER_S) -> Dict[str, str]:
    """Return the type of a service and the name of its node, without calling it.

    :param name: global name of the service
    :param timeout: longest wait [s]
    :returns: the server's header: ``type`` and ``md5sum`` of the service, ``callerid`` for the name
        of the node
    :raises CallError: if the service does not respond
    :raises ValueError: if the time-out is invalid
    """
    check_timeout(timeout)
    return _Server(name, None).probe(ServiceCall(timeout))


def _close_all() -> None:
    for client in list(PROCESS.instances(Client)):
        client.close()


at_end(ShutdownPhase.TOOLKIT, _close_all)
