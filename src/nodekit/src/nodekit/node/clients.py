"""Call services, with a time-out and without waiting where one would wait for ever."""

import concurrent.futures
import contextlib
import io
import math
import socket
import threading
import time
import weakref
from functools import partial
from typing import Any, Callable, Dict, NoReturn, Optional, Set, Tuple

import genpy
import rospy
from rosgraph.network import parse_http_host_and_port as host_and_port

from nodekit.groups.callback_groups import NoGroup
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.node.callbacks import Callback, ServiceCallback
from nodekit.rospy_internals.shutdown import Ending, at_end
from nodekit.transport.service_call import CallFailed, ServiceCall
from nodekit.validation import (
    check_function,
    check_service_class,
    check_timeout,
    check_wait,
)

#: How long a call takes at most where the user does not say, s.
TIMEOUT_S = 5.0
#: How long a node may take to answer whoever only looks, s.
ANSWER_S = 2.0
#: Most calls of one client that are under way at once.
MOST_CALLS = 200
#: Time between two looks for a service that is not there yet, s, and between two lines about it.
_LOOK_EVERY_S, _TELL_EVERY_S = 0.1, 1.0


class CallError(rospy.ServiceException):
    """A call without an answer; the text names the service and says why."""


class CallTimeout(CallError):
    """A call that was not answered in time."""


class CallCancelled(CallError):
    """A call that was cancelled, or ended by the end of its node."""


class NestedCall(CallError):
    """A call that would wait for its own caller; it is refused."""


class _Server:
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
            raise CallError(f"{self.name} sent a malformed reply: {error}") from None

    def probe(self, call: ServiceCall) -> Dict[str, str]:
        """Return what it says of itself, if it could answer.

        :param call: how, and how long
        :raises CallError: if it could not
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
            # The master, too, may be what has taken all the time.
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
            host.encode("idna")  # as connecting to it does
        except ValueError as error:
            raise ConnectionError(f"it is offered at {found!r}: {error}") from None
        return host, port


class CallFuture(concurrent.futures.Future):
    """The answer to a call, which comes later, but by the deadline.

    :param client: whose
    :param timeout: longest time to it, s
    """

    def __init__(self, client: "Client", timeout: float) -> None:
        super().__init__()
        self._client = client
        self._call = ServiceCall(timeout)

    def result(self, timeout: Optional[float] = None) -> Any:
        """Wait for the answer.

        :param timeout: longest wait, s; at most, and by default, up to the call's own deadline
        :raises CallTimeout: if there is none in time
        :raises CallCancelled: if the call was cancelled
        :raises NestedCall: if the server waits for the calling thread
        :raises CallError: if the service is not there, or replied with an error
        """
        if not self.done():
            self._client.refuse_nested()
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
        """Wait for the answer no longer; the server learns of it only if it looks.

        :returns: whether it was cancelled; False where it is done
        """
        is_cancelled = super().cancel()
        self._call.cancel()
        return is_cancelled

    def add_done_callback(self, function: Callable[["CallFuture"], Any]) -> None:
        """Have a function called with this when it is done, in the client's callback group.

        :param function: what to call
        :raises TypeError: if it is no function, or async
        """
        check_function(function, f"{self._client.name}: add_done_callback")
        super().add_done_callback(lambda _: self._client.done.offer(partial(self._tell, function)))

    def _tell(self, function: Callable[["CallFuture"], Any]) -> None:
        self._client.done.call_inside(function, self)

    def run(self, request: bytes) -> None:
        """Make the call, in a thread of its own.

        :param request: serialised
        """
        try:
            answer, error = self._client.server.answer(self._call, request), None
        except Exception as failure:  # of any kind: it is told where the answer is waited for
            answer, error = None, failure
        with contextlib.suppress(concurrent.futures.InvalidStateError):  # cancelled: nobody waits
            if error is None:
                self.set_result(answer)
            else:
                self.set_exception(error)
        self._client.under_way.discard(self)


class Client:
    """Calls one service; each call has a connection of its own, so that answers never swap.

    :param name: of the service, resolved
    :param service_class: its type
    :param done: calls back when calls are done
    :raises TypeError: if the class is not that of a service
    """

    def __init__(self, name: str, service_class: Any, done: Callback) -> None:
        check_service_class(service_class, name)
        self.name, self.done = name, done
        self.server = _Server(name, service_class)
        self.under_way: Set[CallFuture] = set()
        self._is_closed = False
        _clients.add(self)

    def call(self, request: Any, timeout: float = TIMEOUT_S) -> Any:
        """Call the service and wait for the answer.

        :param request: of the service's request class
        :param timeout: longest wait, s
        :returns: the answer
        :raises CallError: if there is none, see :meth:`CallFuture.result`
        """
        self.refuse_nested()
        return self.call_async(request, timeout).result()

    def call_async(self, request: Any, timeout: float = TIMEOUT_S) -> CallFuture:
        """Call the service.

        :param request: of the service's request class
        :param timeout: longest time to the answer, s
        :returns: the answer, which comes later
        :raises CallError: if the request cannot be sent, or too many are under way
        :raises ValueError: if the time-out is none
        """
        check_timeout(timeout)
        if self._is_closed or rospy.is_shutdown():
            raise CallCancelled(f"{self.name} is not called: its client is closed")
        if len(self.under_way) >= MOST_CALLS:
            raise CallError(f"{self.name} is not called: {MOST_CALLS} calls are under way already")
        content = self.server.serialised(request)
        future = CallFuture(self, timeout)
        self.under_way.add(future)
        threading.Thread(
            target=future.run, args=(content,), name=f"call of {self.name}", daemon=True
        ).start()
        return future

    def wait_for_service(self, timeout: float = math.inf) -> bool:
        """Wait until the service can be called; say each second that it cannot.

        :param timeout: longest wait, s; by default, until the node ends. With 0 it is looked once,
            which takes up to 0.1 s where the server does not answer
        :returns: whether it can be called now
        :raises ValueError: if the time-out is no number
        """
        check_wait(timeout)
        began = told = time.monotonic()
        while not (self._is_closed or rospy.is_shutdown()):
            left = began + timeout - time.monotonic()
            with contextlib.suppress(CallError):
                self.server.probe(ServiceCall(min(max(left, _LOOK_EVERY_S), _TELL_EVERY_S)))
                return True
            if time.monotonic() >= told + _TELL_EVERY_S:
                told = time.monotonic()
                rospy.loginfo("service %s is not available, waiting again...", self.name)
            if left <= 0.0:
                break
            time.sleep(min(_LOOK_EVERY_S, max(0.0, left)))
        return False

    def close(self) -> None:
        """Cancel all calls that are under way, and make none any more."""
        self._is_closed = True
        for future in list(self.under_way):
            future.cancel()

    def refuse_nested(self) -> None:
        """Refuse to wait for a service of this process that waits for the calling thread.

        :raises NestedCall: if it does
        """
        answering = ServiceCallback.offered.get(self.name)
        if answering is not None and answering.waits_for_caller():
            raise NestedCall(
                f"{self.name} is not called: it is answered in the callback group or by the thread"
                " that would wait for it; give the service a group of its own, or call it"
                " asynchronously"
            )


def call_service(
    name: str, service_class: Any, *fields: Any, timeout: float = ANSWER_S
) -> CallFuture:
    """Call a service once, without a node's class, as a command or another node's tool does.

    :param name: global name of the service
    :param service_class: its type
    :param fields: of the request, in their order
    :param timeout: longest time to the answer, s
    :returns: the answer, which comes later
    :raises CallError: if the request cannot be sent
    :raises ValueError: if the time-out is none
    """
    done = Callback(NoGroup(), lambda function, future: function(future), name)
    client = Client(name, service_class, done)
    return client.call_async(service_class._request_class(*fields), timeout)


def probe_service(name: str, timeout: float = ANSWER_S) -> Dict[str, str]:
    """Ask a service of any type what it is, without calling it.

    :param name: global name of the service
    :param timeout: longest wait, s
    :returns: what its server says of itself: ``type`` and ``md5sum`` of the service, ``callerid``
        for the name of the node
    :raises CallError: if it does not answer
    :raises ValueError: if the time-out is none
    """
    check_timeout(timeout)
    return _Server(name, None).probe(ServiceCall(timeout))


_clients: "weakref.WeakSet[Client]" = weakref.WeakSet()


def _close_all() -> None:
    for client in list(_clients):
        client.close()


at_end(Ending.TOOLKIT, _close_all)
