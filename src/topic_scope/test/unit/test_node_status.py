"""Status topics of nodes, and the messages for pages."""

from typing import Collection, List, Mapping
from unittest import mock

from bags import serialized
from std_msgs.msg import String

from topic_scope.controls.node_status import NodeStatuses, topics_of
from topic_scope.sampling.message_source import Batch


def test_status_topics_have_one_publisher_and_a_status_name() -> None:
    publishers = [
        ("/a/status", ["/a"]),
        ("/b/motor_state", ["/b"]),
        ("/c/status", ["/c"]),  # of another type
        ("/d/estate", ["/d"]),
        ("/shared/state", ["/a", "/e"]),
        ("/f/status", ["/f"]),  # has no panel
    ]
    types = {topic: "std_msgs/String" for topic, _ in publishers}
    types["/c/status"] = "std_msgs/Float32"
    nodes = ["/a", "/b", "/c", "/d", "/e"]
    found = {"/a": "/a/status", "/b": "/b/motor_state"}
    assert topics_of(nodes, publishers, types) == found
    second = ("/a/state", ["/a"])
    types["/a/state"] = "std_msgs/String"
    assert topics_of(nodes, [*publishers, second], types) == {**found, "/a": "/a/state"}


class FakeSubscriptions:
    """Subscriptions to one topic, filled by the test."""

    is_to_adjust = False

    def __init__(self) -> None:
        self.batches: List[Batch] = []
        self.wanted: Collection[str] = ()

    def want(self, topics: Collection[str]) -> None:
        self.wanted = topics

    def subscriptions(self) -> Mapping[str, "FakeSubscriptions"]:
        return {"/a/status": self}

    def drain(self) -> List[Batch]:
        batches, self.batches = self.batches, []
        return batches

    def receive(self, *texts: str, kind: str = "String") -> None:
        messages = [serialized(String(text)) for text in texts]
        self.batches.append(Batch({"type": "std_msgs/" + kind}, [0] * len(texts), messages))


def test_pages_receive_only_changes() -> None:
    send, source = mock.Mock(), FakeSubscriptions()
    statuses = NodeStatuses(source, mock.Mock(), send)  # type: ignore[arg-type]
    statuses.follow({"/a": "/a/status"})
    assert source.wanted == {"/a/status"}
    for texts in (["running well"], ["idle", "running"], ["running", "idle"], [""], []):
        if texts:
            source.receive(*texts)
        statuses.update()
    statuses_sent = [call[0][0]["nodes"]["/a"] for call in send.call_args_list]
    assert statuses_sent == ["running", "idle", ""]
    source.receive("later", kind="Float32")
    statuses.update()
    source.receive("starting")
    source.receive("stopped")  # by another connection
    statuses.update()
    assert send.call_args_list.pop()[0][0]["nodes"] == {"/a": "stopped"}
    statuses.follow({"/a": "/a/motor_status"})  # another topic: its status is not known yet
    assert [call[0][0]["nodes"] for call in send.call_args_list[3:]] == [{}]
