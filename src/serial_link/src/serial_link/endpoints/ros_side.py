"""ROS side of a board: opens its topics and services, and handles its events."""

import threading
import time
import traceback
from typing import Any, Callable, Dict, List, Optional, Set, Tuple

import rospy

from nodekit import IllegalName, NodeScope
from serial_link.endpoints.log_lines import LogLines
from serial_link.endpoints.parameter_values import UnsupportedValue, encode_answer
from serial_link.endpoints.null_endpoint import NullEndpoint
from serial_link.endpoints.services import CalledService, OfferedService
from serial_link.endpoints.topics import PublishedTopic, SubscribedTopic
from serial_link.endpoints.types import MalformedMessage, TypeRefused
from serial_link.framing.frames import LONGEST
from serial_link.host.baud_pacing import explain_drop
from serial_link.host.counters import MALFORMED, Counters
from serial_link.link.events import (
    Synced,
    LogLine,
    Message,
    ParameterRequest,
    Restarted,
    Topics,
)
from serial_link.link.board_link import BoardLink
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.payloads import (
    PARAMETER,
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    ParameterValues,
    encode_values,
    problem_of,
)
from serial_link.negotiation.topic_table import SERVICES, Endpoint

_LONGEST_WAIT_S, _RETRY_S, _WARN_EVERY_S = 1.0, 1.0, 10.0
_WORDS = {
    PUBLISHER: "publishes",
    SUBSCRIBER: "subscribes to",
    SERVICE_SERVER: "offers",
    SERVICE_CLIENT: "calls",
}
#: Identity of a topic or service, independent of its ids: kind, name, type, number and md5sums.
_Key = Tuple[Any, ...]


class RosSide:
    """ROS side of a board: its topics, services, parameters and log, in one thread.

    :param scope: creates topics and services
    :param link: to the board
    :param counters: counts faults
    :param timeout: returns the timeout of a service call [s]
    :param find_parameter: returns the raw value of a parameter, given its global name; None if it
        is unset
    :param space: namespace of the board below the node's; empty for the node's own
    """

    def __init__(
        self,
        scope: NodeScope,
        link: BoardLink,
        counters: Counters,
        timeout: Callable[[], float],
        find_parameter: Callable[[str], Any],
        space: str = "",
    ) -> None:
        self._scope, self._link, self._counters = scope, link, counters
        self._timeout, self._find_parameter = timeout, find_parameter
        self._space = space
        self._log = LogLines(scope, f"{scope.name}/{space or 'board'}")
        #: Topics announced by the board since its start; and topics open in ROS, which may be more
        #: until the board has announced all.
        self._wanted: Dict[_Key, Endpoint] = {}
        self._open: Dict[_Key, Tuple[Any, Any]] = {}
        #: Those that the last announcement opened, so that they receive what is latched anyway.
        self._just_opened: Set[_Key] = set()
        #: Whether the board has announced topics since its start, and thereby its buffer size; and
        #: the last parameter request before.
        self._is_known = False
        self._asked: Optional[ParameterRequest] = None
        self._retry_at = 0.0
        #: Topics of the board for which a message was received.
        self._published: Dict[Endpoint, PublishedTopic] = {}
        self._throttled_log = ThrottledLog(_WARN_EVERY_S)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="board", daemon=True)

    def start(self) -> None:
        """Start the threads."""
        self._link.receive_now = self._receive_now
        self._thread.start()

    def close(self) -> None:
        """Stop the threads."""
        self._is_over.set()
        self._link.inbox.close()
        if self._thread.ident is not None:
            self._thread.join(1.0)

    def _run(self) -> None:
        while not self._is_over.is_set():
            try:
                self._handle(self._link.inbox.get(_LONGEST_WAIT_S))
            except Exception:
                self._throttled_log.log(rospy.logerr, traceback.format_exc(), "exception")

    def _handle(self, arrival: Optional[Any]) -> None:
        if isinstance(arrival, Message):
            self._receive(arrival)
        elif isinstance(arrival, Topics):
            self._update(*arrival)
            self._is_known = True
            if self._asked is not None:
                self._answer(self._asked)
            self._asked = None
        elif isinstance(arrival, LogLine):
            self._log.write(*arrival)
        elif isinstance(arrival, ParameterRequest):
            if self._is_known:
                self._answer(arrival)
            else:
                if self._asked is not None:
                    self._is_outdated(self._asked)  # logs that it is not answered
                self._asked = arrival
        elif isinstance(arrival, Restarted):
            self._is_known, self._asked = False, None
            self._wanted.clear()
            for _, endpoint_in_ros in self._open.values():
                endpoint_in_ros.on_lost(arrival.why)
        elif isinstance(arrival, Synced):
            for key in self._open.keys() - self._just_opened:
                self._open[key][1].on_sync()
        if time.monotonic() > self._retry_at and not self._wanted.keys() <= self._open.keys():
            self._retry_at = time.monotonic() + _RETRY_S
            for key, endpoint in list(self._wanted.items()):
                self._opened(key, endpoint)

    def _receive(self, message: Message) -> None:
        # A board may send right after the request for its topics, before all are known.
        endpoint_in_ros = self._opened(_key(message.endpoint), message.endpoint)
        if isinstance(endpoint_in_ros, PublishedTopic):
            self._published[message.endpoint] = endpoint_in_ros
        try:
            endpoint_in_ros.receive(message.payload)
        except MalformedMessage:
            self._counters.add(MALFORMED)

    def _receive_now(self, endpoint: Endpoint, payload: bytes) -> bool:
        """Publish a message in the reader thread, if its topic is open and no event waits.

        Waking up the other thread would take longer than all other work for a message.

        :returns: whether the message was handled
        """
        topic = self._published.get(endpoint)
        if topic is None or not self._link.inbox.is_idle:
            return False
        try:
            topic.receive(payload)
        except MalformedMessage:
            self._counters.add(MALFORMED)
        except Exception:
            self._throttled_log.log(rospy.logerr, traceback.format_exc(), "exception")
        return True

    def _update(self, endpoints: List[Endpoint], is_complete: bool) -> None:
        """Open the board's current topics; close the others once the board has announced all."""
        before = set(self._open) if is_complete else self._wanted.keys() & self._open.keys()
        self._wanted = _keyed(endpoints)
        for key in before - self._wanted.keys():
            self._close(key)
        self._just_opened = self._wanted.keys() - self._open.keys()
        for key, endpoint in list(self._wanted.items()):
            self._opened(key, endpoint)

    def _close(self, key: _Key) -> None:
        self._published.clear()
        scope, _ = self._open.pop(key)
        scope.close()
        rospy.loginfo("the board no longer %s %s", _WORDS[key[0]], self._placed(key[1]))

    def _opened(self, key: _Key, endpoint: Endpoint) -> Any:
        self._wanted[key] = endpoint
        if key in self._open:
            endpoint_in_ros = self._open[key][1]
            endpoint_in_ros.update(endpoint)
            return endpoint_in_ros
        for other in set(self._open) - set(self._wanted):
            is_like_it = (other[0] in SERVICES) == endpoint.is_service
            if is_like_it and other[1] == endpoint.name and other[2] != endpoint.type:
                self._close(other)  # the previous sketch used another type
        scope = self._scope.create_scope()
        placed = endpoint._replace(name=self._placed(endpoint.name))
        try:
            endpoint_in_ros = self._create(scope, placed)
            words = _WORDS[endpoint.kind]
            rospy.loginfo("the board %s %s (%s)", words, placed.name, placed.type)
        except (TypeRefused, IllegalName, rospy.ROSException) as error:
            scope.close()
            is_called = endpoint.kind == SERVICE_CLIENT
            effect = ", and the board's calls end with an unchanged response" if is_called else ""
            rospy.logerr("%s is refused%s: %s", ascii(placed.name)[1:-1], effect, error)
            endpoint_in_ros = NullEndpoint(self._counters, self._link if is_called else None)
        except Exception:
            scope.close()
            raise
        self._open[key] = (scope, endpoint_in_ros)
        return endpoint_in_ros

    def _create(self, scope: NodeScope, endpoint: Endpoint) -> Any:
        link, counters = self._link, self._counters
        for info in (endpoint.incoming, endpoint.outgoing):
            if info is not None and problem_of(info):
                raise TypeRefused(problem_of(info))
        if endpoint.kind == PUBLISHER:
            return PublishedTopic(scope, endpoint)
        if endpoint.kind == SUBSCRIBER:
            return SubscribedTopic(scope, endpoint, link, counters)
        kind = OfferedService if endpoint.kind == SERVICE_SERVER else CalledService
        return kind(scope, endpoint, link, counters, self._timeout)

    def _answer(self, request: ParameterRequest) -> None:
        """Send a parameter to the board, which waits for it: an empty answer if it has no value."""
        name, payload = request.name, encode_values(ParameterValues())
        if self._is_outdated(request):
            return
        try:
            resolved = self._scope.resolve(self._placed(name))
            raw = self._find_parameter(resolved)
            if raw is None:
                self._warn(f"the board asks for {resolved}, which is not set")
            else:
                payload = encode_answer(raw, self._buffer_size())
                problem = explain_drop(len(payload), self._link.baud)
                if problem:
                    self._warn(f"the board asks for {name}: {problem}")
        except (UnsupportedValue, IllegalName, ConnectionError) as error:
            self._warn(f"the board asks for {name}: {error}")
        if not self._is_outdated(request):
            self._link.answer(PARAMETER, payload)

    def _is_outdated(self, request: ParameterRequest) -> bool:
        """Return whether the board may no longer wait for an answer, and log that."""
        requests = self._link.parameter_requests
        is_outdated = not requests.is_pending(time.monotonic(), request.number)
        if is_outdated:
            self._warn(
                f"the board's request for {request.name} is not answered: it may have timed out on "
                "the board, which would take the answer for that of its next request"
            )
        return is_outdated

    def _warn(self, text: str) -> None:
        """Log a warning, throttled: a sketch may ask for the same parameter in its loop."""
        self._throttled_log.log(rospy.logwarn, text)

    def _placed(self, name: str) -> str:
        """Return a name with the board's namespace, unless it is global or private."""
        is_relative = self._space and not name.startswith(("/", "~"))
        return f"{self._space}/{name}" if is_relative else name

    def _buffer_size(self) -> int:
        """Return the longest payload that the board accepts, as far as known [bytes]."""
        infos = [endpoint.outgoing for endpoint in self._wanted.values()]
        return min([LONGEST, *(info.buffer_size for info in infos if info is not None)])


def _key(endpoint: Endpoint, number: int = 0) -> _Key:
    sums = (info.md5sum for info in (endpoint.incoming, endpoint.outgoing) if info is not None)
    return (endpoint.kind, endpoint.name, endpoint.type, number, *sums)


def _keyed(endpoints: List[Endpoint]) -> Dict[_Key, Endpoint]:
    """Return endpoints by their keys; subscribers to one topic are numbered by their ids."""
    found: Dict[_Key, Endpoint] = {}
    for endpoint in sorted(endpoints, key=_id):
        number = 0
        while endpoint.kind == SUBSCRIBER and _key(endpoint, number) in found:
            number += 1
        found[_key(endpoint, number)] = endpoint
    return found


def _id(endpoint: Endpoint) -> int:
    info = endpoint.outgoing or endpoint.incoming
    return info.topic_id if info is not None else 0
