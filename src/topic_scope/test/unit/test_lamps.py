"""On which topic a node says how it is."""

from topic_scope.lamps import topics_of


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
