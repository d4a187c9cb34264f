"""Services of a board in ROS: servers and clients."""

import threading
from functools import partial
from typing import Any, Optional

import rospy

from nodekit import (
    CallError,
    CallFuture,
    MutuallyExclusiveCallbackGroup,
    NodeScope,
    ReentrantCallbackGroup,
)
from serial_link.endpoints.types import MalformedMessage, decode, encode, md5sums_of, service_class
from serial_link.host.baud_pacing import explain_drop
from serial_link.host.counters import TOO_LARGE, Counters
from serial_link.link.board_link import BoardLink
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.payloads import SERVICE_SERVER
from serial_link.negotiation.topic_table import Endpoint

_WARN_EVERY_S = 10.0


class _Service:
    """Base class of services.

    :param endpoint: of the board
    :param link: sends to the board
    :param counters: counts messages that are too large
    :raises TypeRefused: if the board's type differs from the installed one
    """

    def __init__(self, endpoint: Endpoint, name: str, link: BoardLink, counters: Counters) -> None:
        self.update(endpoint)
        sums = md5sums_of(endpoint.incoming, endpoint.outgoing, endpoint.kind, SERVICE_SERVER)
        self.service_class = service_class(endpoint.type, *sums)
        self.name, self._link, self._counters = name, link, counters

    def update(self, endpoint: Endpoint) -> None:
        """Update the service's id and buffer size."""
        assert endpoint.outgoing is not None
        self._info = endpoint.outgoing

    def on_sync(self) -> None:
        """Board synchronized: nothing to do."""

    def send(self, message: Any) -> str:
        """Send a request or a response to the board.

        :returns: why rosserial's library drops it, or an empty text
        :raises CallError: if sending fails
        """
        payload = encode(message)
        size = self._info.buffer_size
        if len(payload) > size:
            self._counters.add(TOO_LARGE)
            raise CallError(
                f"{self.name}: a message of {len(payload)} bytes is not sent: the board's buffer "
                f"has {size}"
            )
        if not self._link.send_reliable(self._info, payload):
            why = "the board has not announced it again, or the send queue is full"
            raise CallError(f"{self.name}: {self._link.trouble or why}")
        return explain_drop(len(payload), self._link.baud)


class OfferedService(_Service):
    """Service offered by the board, which answers one call at a time.

    The protocol does not number responses. So a call after one that has timed out first waits for
    the late response, at most as long again.

    :param scope: creates the service
    :param endpoint: of the board
    :param timeout: returns the timeout of a call [s]
    """

    def __init__(
        self,
        scope: NodeScope,
        endpoint: Endpoint,
        link: BoardLink,
        counters: Counters,
        timeout: Any,
    ) -> None:
        super().__init__(endpoint, scope.resolve(endpoint.name), link, counters)
        self._timeout = timeout
        #: Set while no response is outstanding.
        self._is_done = threading.Event()
        self._is_done.set()
        self._response: Any = None
        self._failure = ""
        scope.create_service(
            endpoint.name, self.service_class, self._call, group=MutuallyExclusiveCallbackGroup()
        )

    def receive(self, payload: bytes) -> None:
        """Pass on the board's response.

        :raises MalformedMessage: if it is malformed
        """
        self._response = decode(self.service_class._response_class, payload)
        self._is_done.set()

    def on_lost(self, why: str) -> None:
        """Board lost: fail a running call immediately."""
        self._failure = why
        self._is_done.set()

    def _call(self, request: Any) -> Any:
        timeout = self._timeout()
        self._is_done.wait(timeout)  # for the response of a call that has timed out
        self._is_done.clear()
        self._response, self._failure = None, ""
        try:
            problem = self.send(request)
        except CallError:
            self._is_done.set()
            raise
        if not self._is_done.wait(timeout):
            late = f"{self.name}: the board has not answered within {timeout:g} s"
            raise CallError(f"{late}: {problem}" if problem else late)
        if self._response is None:
            raise CallError(f"{self.name}: {self._failure}")
        return self._response


class CalledService(_Service):
    """Service called by the board.

    The protocol has no error response: a failure is logged, and the board's topics are requested,
    after which rosserial's library stops waiting.

    :param scope: creates the client
    :param endpoint: of the board
    :param timeout: returns the timeout of a call [s]
    """

    def __init__(
        self,
        scope: NodeScope,
        endpoint: Endpoint,
        link: BoardLink,
        counters: Counters,
        timeout: Any,
    ) -> None:
        super().__init__(endpoint, scope.resolve(endpoint.name), link, counters)
        self._timeout = timeout
        self._era = 0
        self._throttled_log = ThrottledLog(_WARN_EVERY_S)
        group = ReentrantCallbackGroup()
        self._client = scope.create_client(endpoint.name, self.service_class, group=group)

    def receive(self, payload: bytes) -> None:
        """Call the service for the board.

        :raises MalformedMessage: if the request is malformed
        """
        try:
            request = decode(self.service_class._request_class, payload)
            future = self._client.call_async(request, self._timeout())
        except MalformedMessage:
            self._link.request_topics()
            raise
        except CallError as error:
            self._fail(self._era, error)
        else:
            future.add_done_callback(partial(self._answer, self._era))

    def on_lost(self, why: str) -> None:
        """Board lost: drop the answers of running calls."""
        self._era += 1

    def _answer(self, era: int, future: CallFuture) -> None:
        try:
            response: Optional[Any] = future.result()
            problem = self.send(response) if era == self._era else ""
            if problem:
                raise CallError(f"{self.name}: {problem}")
        except (CallError, MalformedMessage) as error:
            self._fail(era, error)

    def _fail(self, era: int, error: Exception) -> None:
        self._throttled_log.log(rospy.logwarn, f"the board's call failed: {error}")
        if era == self._era:  # else the board was restarted, and may wait for a later call
            self._link.request_topics()
