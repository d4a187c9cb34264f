"""Messages for a topic that the board subscribes to."""

from typing import Any, Callable, List

import pytest
from std_msgs.msg import String

from serial_link.endpoints.topics import SubscribedTopic
from serial_link.host.counters import TOO_LARGE, Counters
from serial_link.negotiation.payloads import SUBSCRIBER, TopicInfo
from serial_link.negotiation.topic_table import Endpoint

INFO = TopicInfo(100, "told", String._type, String._md5sum, 280)


class FakeContext:
    """Scope of a topic, and link to its board."""

    baud = 57600

    def __init__(self) -> None:
        self.sent: List[bytes] = []

    def create_scope(self) -> "FakeContext":
        return self

    def resolve(self, name: str) -> str:
        return "/" + name

    def create_subscription(
        self, name: str, raw: Any, on_message: Callable[[Any], None], group: Any
    ) -> None:
        self.raw, self.on_message = raw, on_message

    def receive(self, payload: bytes) -> None:
        message = self.raw().deserialize(payload)
        message._connection_header = {}
        self.on_message(message)

    def send(self, info: TopicInfo, payload: bytes) -> None:
        self.sent.append(payload)


def test_message_that_takes_longer_than_the_library_waits_is_logged_and_sent(
    caplog: "pytest.LogCaptureFixture",
) -> None:
    around: Any = FakeContext()
    counters = Counters()
    SubscribedTopic(around, Endpoint(SUBSCRIBER, *INFO[1:3], None, INFO), around, counters)
    around.receive(bytes(107))
    assert not caplog.text
    around.receive(bytes(108))
    assert "/told: 108 bytes take longer than the 20 ms" in caplog.text
    around.receive(bytes(281))  # its warning has a separate rate limit
    assert "/told: a message of 281 bytes is not sent: the board's buffer has 280" in caplog.text
    assert [len(payload) for payload in around.sent] == [107, 108]
    assert counters.to_dict() == {TOO_LARGE: 1}
