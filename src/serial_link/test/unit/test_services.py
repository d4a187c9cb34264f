"""Services of a board: called or offered by it."""

import threading
from typing import Any, Callable, List, Optional

import pytest

from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from nodekit import CallError, MutuallyExclusiveCallbackGroup
from serial_link.endpoints.services import CalledService, OfferedService
from serial_link.endpoints.types import MalformedMessage, encode
from serial_link.host.counters import TOO_LARGE, Counters
from serial_link.negotiation.payloads import SERVICE_CLIENT, SERVICE_SERVER, TopicInfo
from serial_link.negotiation.topic_table import Endpoint

REQUEST, RESPONSE = SetBool._request_class._md5sum, SetBool._response_class._md5sum
ENDPOINT = Endpoint(
    SERVICE_CLIENT,
    "called",
    "std_srvs/SetBool",
    TopicInfo(125, "called", "std_srvs/SetBool", REQUEST, 280),
    TopicInfo(100, "called", "std_srvs/SetBool", RESPONSE, 280),
)
OFFERED = ENDPOINT._replace(
    kind=SERVICE_SERVER, incoming=ENDPOINT.outgoing, outgoing=ENDPOINT.incoming
)


class Call:
    """Call with a result, or one that fails."""

    def __init__(self, answer: Any, is_late: bool) -> None:
        self.answer = answer
        self.is_late = is_late

    def add_done_callback(self, callback: Callable[[Any], None]) -> None:
        self.end = lambda: callback(self)
        if not self.is_late:
            self.end()

    def result(self) -> Any:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class FakeContext:
    """Scope, client and link of the service."""

    trouble = ""
    baud = 0

    def __init__(self, answer: Any) -> None:
        self.answer = answer
        self.sent = self.requests = 0
        self.is_late = False
        self.running: List[Call] = []

    def resolve(self, name: str) -> str:
        return "/" + name

    def create_client(self, *arguments: Any, **options: Any) -> "FakeContext":
        return self

    def call_async(self, request: Any, timeout: float) -> Call:
        if self.answer is None:
            raise CallError("no node offers it")
        self.timeout = timeout
        self.running.append(Call(self.answer, self.is_late))
        return self.running[-1]

    def send_reliable(self, info: TopicInfo, payload: bytes) -> bool:
        self.sent += 1
        return True

    def request_topics(self) -> None:
        self.requests += 1


def test_call_that_fails_is_logged_and_requests_the_topics_and_an_answered_one_does_not(
    caplog: "pytest.LogCaptureFixture",
) -> None:
    for answer, sent, requests in (
        (SetBoolResponse(True, "on"), 1, 0),
        (CallError("not answered within 5 s"), 0, 1),
        (None, 0, 1),
    ):
        around: Any = FakeContext(answer)
        service = CalledService(around, ENDPOINT, around, Counters(), lambda: 5.0)
        service.receive(encode(SetBoolRequest(True)))
        assert (around.sent, around.requests) == (sent, requests)
    assert "the board's call failed: not answered within 5 s" in caplog.text


def test_call_of_the_board_has_the_present_timeout() -> None:
    around: Any = FakeContext(SetBoolResponse(True, "on"))
    timeout = 5.0
    service = CalledService(around, ENDPOINT, around, Counters(), lambda: timeout)
    timeout = 0.5
    service.receive(encode(SetBoolRequest(True)))
    assert around.timeout == 0.5


def test_response_beyond_the_buffer_of_the_board_is_not_sent_and_requests_the_topics(
    caplog: "pytest.LogCaptureFixture",
) -> None:
    assert ENDPOINT.outgoing is not None
    counters = Counters()
    for size, sent in ((7, 1), (6, 0)):
        around: Any = FakeContext(SetBoolResponse(True, "on"))
        small = ENDPOINT._replace(outgoing=ENDPOINT.outgoing._replace(buffer_size=size))
        CalledService(around, small, around, counters, lambda: 5.0).receive(
            encode(SetBoolRequest(True))
        )
        assert (around.sent, around.requests) == (sent, 1 - sent)
    assert "/called: a message of 7 bytes is not sent: the board's buffer has 6" in caplog.text
    assert counters.to_dict() == {TOO_LARGE: 1}


def test_response_that_takes_longer_than_the_library_waits_is_sent_and_requests_the_topics(
    caplog: "pytest.LogCaptureFixture",
) -> None:
    for length, requests in ((107, 0), (108, 1)):
        around: Any = FakeContext(SetBoolResponse(True, "x" * (length - 5)))
        around.baud = 57600
        service = CalledService(around, ENDPOINT, around, Counters(), lambda: 5.0)
        service.receive(encode(SetBoolRequest(True)))
        assert (around.sent, around.requests) == (1, requests)
    assert caplog.text.count("the board's call failed") == 1
    assert "/called: 108 bytes take longer than the 20 ms after which rosserial's" in caplog.text


@pytest.mark.parametrize(
    "answer", [CallError("not answered within 5 s"), SetBoolResponse(True, "on")]
)
def test_call_from_before_a_restart_sends_and_requests_nothing_after_it(answer: Any) -> None:
    around: Any = FakeContext(answer)
    around.is_late = True
    service = CalledService(around, ENDPOINT, around, Counters(), lambda: 5.0)
    service.receive(encode(SetBoolRequest(True)))
    service.on_lost("the board was restarted")
    around.running[0].end()
    assert (around.sent, around.requests) == (0, 0)


def test_malformed_request_requests_the_topics() -> None:
    around: Any = FakeContext(None)
    service = CalledService(around, ENDPOINT, around, Counters(), lambda: 5.0)
    with pytest.raises(MalformedMessage):
        service.receive(b"")
    assert around.requests == 1


class BoardContext:
    """Scope of a service that the board offers, and link to the board."""

    trouble = ""
    baud = 0

    def __init__(self) -> None:
        self.on_request: Callable[[], None] = lambda: None
        self.is_sent = True

    def resolve(self, name: str) -> str:
        return "/" + name

    def create_service(self, name: str, _class: Any, call: Any, group: Any) -> None:
        self.call, self.group = call, group

    def send_reliable(self, info: TopicInfo, payload: bytes) -> bool:
        self.on_request()
        return self.is_sent


def test_call_fails_if_the_board_is_lost_although_an_earlier_one_was_answered() -> None:
    around: Any = BoardContext()
    service = OfferedService(around, OFFERED, around, Counters(), lambda: 5.0)
    around.on_request = lambda: service.receive(encode(SetBoolResponse(True, "on")))
    assert around.call(SetBoolRequest(True)).message == "on"
    around.on_request = lambda: service.on_lost("the board was restarted")
    with pytest.raises(CallError, match="^/called: the board was restarted$"):
        around.call(SetBoolRequest(True))


class Responses(threading.Event):
    """Event of a service that a response arrives; each wait receives the next one, or times out."""

    def __init__(self, service: OfferedService, *texts: str) -> None:
        super().__init__()
        if service._is_done.is_set():  # so that the first call is sent at once
            self.set()
        self._service, self._texts = service, list(texts)

    def wait(self, timeout: Optional[float] = None) -> bool:
        text = "" if self.is_set() else self._texts.pop(0)
        if text:
            self._service.receive(encode(SetBoolResponse(True, text)))
        return self.is_set()


def test_late_response_is_not_returned_by_the_next_call() -> None:
    around: Any = BoardContext()
    service = OfferedService(around, OFFERED, around, Counters(), lambda: 5.0)
    service._is_done = Responses(service, "", "late", "own", "", "", "after a lost one")
    with pytest.raises(CallError, match="has not answered within 5 s"):
        around.call(SetBoolRequest(True))
    assert around.call(SetBoolRequest(True)).message == "own"
    with pytest.raises(CallError, match="has not answered within 5 s"):
        around.call(SetBoolRequest(True))
    assert around.call(SetBoolRequest(True)).message == "after a lost one"


def test_call_that_cannot_be_sent_does_not_delay_the_next_one() -> None:
    around: Any = BoardContext()
    service = OfferedService(around, OFFERED, around, Counters(), lambda: 5.0)
    around.is_sent = False
    with pytest.raises(CallError, match="the board has not announced it again"):
        around.call(SetBoolRequest(True))
    around.trouble = "the cable is out"
    with pytest.raises(CallError, match="^/called: the cable is out$"):
        around.call(SetBoolRequest(True))
    assert service._is_done.is_set()


def test_error_of_a_call_names_a_request_that_takes_longer_than_the_library_waits() -> None:
    around: Any = BoardContext()
    service = OfferedService(around, OFFERED, around, Counters(), lambda: 0.0)
    for around.baud, reason in ((4500, ""), (4499, ": 1 bytes take longer than the 20 ms .*")):
        with pytest.raises(CallError, match=f"^/called: .* answered within 0 s{reason}$"):
            around.call(SetBoolRequest(True))
        service.receive(encode(SetBoolResponse(True, "late")))
    around.baud = 1200
    around.on_request = lambda: service.receive(encode(SetBoolResponse(True, "on")))
    assert around.call(SetBoolRequest(True)).message == "on"  # some other library took it


def test_calls_that_the_board_cannot_number_are_made_one_at_a_time() -> None:
    around: Any = BoardContext()
    OfferedService(around, OFFERED, around, Counters(), lambda: 5.0)
    assert isinstance(around.group, MutuallyExclusiveCallbackGroup)


def test_call_has_the_present_timeout() -> None:
    around: Any = BoardContext()
    timeout = 5.0
    OfferedService(around, OFFERED, around, Counters(), lambda: timeout)
    for timeout in (0.01, 0.02):
        with pytest.raises(CallError, match=f"has not answered within {timeout} s"):
            around.call(SetBoolRequest(True))


def test_request_beyond_the_buffer_of_the_board_is_refused_and_counted() -> None:
    around: Any = BoardContext()
    counters = Counters()
    service = OfferedService(around, OFFERED, around, counters, lambda: 5.0)
    around.on_request = lambda: service.receive(encode(SetBoolResponse(True, "on")))
    assert OFFERED.outgoing is not None
    service.update(OFFERED._replace(outgoing=OFFERED.outgoing._replace(buffer_size=1)))
    assert around.call(SetBoolRequest(True)).success  # the request has one byte
    service.update(OFFERED._replace(outgoing=OFFERED.outgoing._replace(buffer_size=0)))
    with pytest.raises(CallError, match="a message of 1 bytes is not sent: .* buffer has 0"):
        around.call(SetBoolRequest(True))
    assert counters.to_dict() == {TOO_LARGE: 1}
