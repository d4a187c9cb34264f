"""Messages for a topic that the board subscribes to."""

from typing import Any, Callable, List, Tuple

import pytest
from std_msgs.msg import String

from serial_link.endpoints.topics import PublishedTopic, SubscribedTopic
from serial_link.endpoints.types import TypeRefused
from serial_link.host.counters import TOO_LARGE, Counters
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, TopicInfo
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
    around.receive(bytes(280))
    assert "280 bytes take longer" not in caplog.text  # logged less often than once per message
    around.receive(bytes(281))  # its warning has a separate rate limit
    around.receive(bytes(282))
    assert "/told: a message of 281 bytes is not sent: the board's buffer has 280" in caplog.text
    assert "282 bytes" not in caplog.text
    assert [len(payload) for payload in around.sent] == [107, 108, 280]
    assert counters.to_dict() == {TOO_LARGE: 2}
    caplog.clear()
    around.baud = 0  # TCP
    SubscribedTopic(around, Endpoint(SUBSCRIBER, *INFO[1:3], None, INFO), around, counters)
    around.receive(bytes(280))
    assert not caplog.text and len(around.sent) == 4


def test_publisher_is_compared_with_the_definition_of_the_board() -> None:
    around: Any = FakeContext()
    SubscribedTopic(around, Endpoint(SUBSCRIBER, *INFO[1:3], None, INFO), around, Counters())
    for name in ("_type", "_md5sum", "_full_text", "_has_header"):  # sent to each publisher
        assert getattr(around.raw, name) == getattr(String, name)


def test_topic_of_another_definition_is_refused() -> None:
    around: Any = FakeContext()
    other = INFO._replace(md5sum="0" * 32)
    with pytest.raises(TypeRefused, match="std_msgs/String differs on the board"):
        PublishedTopic(around, Endpoint(PUBLISHER, *INFO[1:3], other, None))
    with pytest.raises(TypeRefused, match="std_msgs/String differs on the board"):
        SubscribedTopic(around, Endpoint(SUBSCRIBER, *INFO[1:3], None, other), around, Counters())


class Subscription:
    """Scope of one subscription, which gets a message while it is made."""

    def __init__(self, board: "Board") -> None:
        self.board, self.is_closed = board, False

    def create_subscription(
        self, name: str, raw: Any, on_message: Callable[[Any], None], group: Any
    ) -> None:
        self.raw, self.on_message = raw, on_message
        self.board.subscriptions[0].receive(b"before")  # not connected to the new one yet
        for subscription in self.board.subscriptions:
            subscription.receive(b"meanwhile")
        self.receive(b"kept", latching="1")

    def receive(self, payload: bytes, **header: str) -> None:
        message = self.raw().deserialize(payload)
        message._connection_header = header
        self.on_message(message)

    def close(self) -> None:
        self.is_closed = True


class Board:
    """Scope of a topic whose publisher has latched a message, and link to its board."""

    baud = 0

    def __init__(self) -> None:
        self.subscriptions: List[Subscription] = []
        self.sent: List[Tuple[str, int, bytes]] = []

    def create_scope(self) -> Subscription:
        self.subscriptions.append(Subscription(self))
        return self.subscriptions[-1]

    def resolve(self, name: str) -> str:
        return "/" + name

    def send(self, info: TopicInfo, payload: bytes) -> None:
        self.sent.append(("stream", info.topic_id, payload))

    def send_latched(self, info: TopicInfo, payload: bytes) -> None:
        self.sent.append(("latched", info.topic_id, payload))


def test_restarted_board_gets_latched_messages_again_and_others_once_under_the_new_id() -> None:
    board: Any = Board()
    endpoint = Endpoint(SUBSCRIBER, *INFO[1:3], None, INFO)
    topic = SubscribedTopic(board, endpoint, board, Counters())
    streams = [("stream", 100, b"before"), ("stream", 100, b"meanwhile")]
    assert board.sent == [*streams, ("latched", 100, b"kept")]
    board.sent.clear()
    topic.update(endpoint._replace(outgoing=INFO._replace(topic_id=101)))
    topic.on_sync()
    streams = [("stream", 101, b"before"), ("stream", 101, b"meanwhile")]
    assert board.sent == [*streams, ("latched", 101, b"kept")]
    before, now = board.subscriptions
    assert before.is_closed and not now.is_closed
    board.sent.clear()
    before.receive(b"kept", latching="1")  # in the thread of the subscription that was closed
    now.receive(b"later")
    assert board.sent == [("stream", 101, b"later")]
