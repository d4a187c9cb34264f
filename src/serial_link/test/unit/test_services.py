"""Services that a board calls."""

from typing import Any, Callable

from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from nodekit import CallError
from serial_link.endpoints.services import CalledService
from serial_link.endpoints.types import encode
from serial_link.host.counters import Counters
from serial_link.negotiation.payloads import SERVICE_CLIENT, TopicInfo
from serial_link.negotiation.topic_table import Endpoint

REQUEST, RESPONSE = SetBool._request_class._md5sum, SetBool._response_class._md5sum
ENDPOINT = Endpoint(
    SERVICE_CLIENT,
    "called",
    "std_srvs/SetBool",
    TopicInfo(125, "called", "std_srvs/SetBool", REQUEST, 280),
    TopicInfo(100, "called", "std_srvs/SetBool", RESPONSE, 280),
)


class Call:
    """Call with a result, or one that fails."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def add_done_callback(self, callback: Callable[[Any], None]) -> None:
        callback(self)

    def result(self) -> Any:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class Surroundings:
    """Scope, client and link of the service."""

    trouble = ""

    def __init__(self, answer: Any) -> None:
        self.answer = answer
        self.sent = self.requests = 0

    def resolve(self, name: str) -> str:
        return "/" + name

    def create_client(self, *arguments: Any, **options: Any) -> "Surroundings":
        return self

    def call_async(self, request: Any, timeout: float) -> Call:
        if self.answer is None:
            raise CallError("no node offers it")
        return Call(self.answer)

    def send_reliable(self, info: TopicInfo, payload: bytes) -> bool:
        self.sent += 1
        return True

    def request_topics(self) -> None:
        self.requests += 1


def test_call_that_fails_requests_the_topics_and_an_answered_one_does_not() -> None:
    for answer, sent, requests in (
        (SetBoolResponse(True, "on"), 1, 0),
        (CallError("not answered within 5 s"), 0, 1),
        (None, 0, 1),
    ):
        around: Any = Surroundings(answer)
        service = CalledService(around, ENDPOINT, around, Counters(), lambda: 5.0)
        service.receive(encode(SetBoolRequest(True)))
        assert (around.sent, around.requests) == (sent, requests)
