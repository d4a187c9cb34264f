"""On which topic a node says how it is, and what pages are told of that."""

from unittest import mock

from topic_scope.controls.lamps import Lamps, topics_of


def test_topics_are_those_of_one_node_that_are_called_so() -> None:
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
    assert topics_of(nodes, publishers, types) == {"/a": "/a/status", "/b": "/b/motor_state"}


def test_pages_are_told_what_is_new_only() -> None:
    tell = mock.Mock()
    lamps = Lamps(mock.Mock(), mock.Mock(), tell)
    lamps.follow({"/a": "/a/status"})
    for text in ("running well", "running", "idle", ""):
        lamps._on_state("/a/status", text)
    told = [call[0][0]["nodes"]["/a"] for call in tell.call_args_list]
    assert told == ["running", "idle", ""]
