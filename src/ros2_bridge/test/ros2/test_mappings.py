"""Types with other fields or names in ROS 2, through a running bridge."""

import pathlib
import struct
import sys
from typing import Any

import both
import genpy.dynamic
import pytest
import rospy
from geometry_msgs.msg import TransformStamped
from nodekit.testing.waiting import wait_until
from visualization_msgs.msg import Marker, MarkerArray

from ros2_bridge.nodes import bridge as bridge_node
from ros2_bridge.nodes.bridge import read_rules


def genpy_class(ros: both.Both, kind: str) -> Any:
    """Return ROS 1's class of a message."""
    text = ros.types.message(kind).raw._full_text
    return genpy.dynamic.generate_dynamic(kind, text)[kind]


def test_markers_cross_in_both_directions(ros: both.Both, bridge: both.Bridge) -> None:
    marker1 = genpy_class(ros, "visualization_msgs/Marker")
    out1 = rospy.Publisher("/marker1", marker1, queue_size=1, latch=True)
    sent = marker1(ns="walls", id=3, text="left")
    sent.scale.x = 0.5
    out1.publish(sent)
    recorder2 = ros.hear2("/marker1", Marker, latched=True)
    heard = recorder2.wait()[0]
    assert (heard.ns, heard.id, heard.scale.x, heard.text) == ("walls", 3, 0.5, "left")
    assert heard.mesh_file.filename == ""
    out2 = ros.node.create_publisher(MarkerArray, "/markers2", 1)
    recorder1 = ros.hear1("/markers2", "visualization_msgs/MarkerArray")
    array = MarkerArray(markers=[Marker(id=number, texture_resource="t") for number in (5, 6)])
    wait_until(lambda: out2.publish(array) or recorder1.heard, lambda: "nothing is heard")
    (count,) = struct.unpack_from("<I", recorder1.heard[0]._buff)
    assert count == 2
    one = marker1().deserialize(recorder1.heard[0]._buff[4:])
    assert (one.id, one.text) == (5, "")
    recorder1.end(), recorder2.end()
    out1.unregister()
    ros.node.destroy_publisher(out2)


RULE = (
    "_mappings:=[{ros1: geometry_msgs/PoseStamped, ros2: geometry_msgs/msg/TransformStamped,"
    " fields: {pose.position: transform.translation, pose.orientation: transform.rotation},"
    " left_out: {ros2: [child_frame_id]}}]"
)


def test_rule_of_the_user_gives_a_topic_another_type_in_ros2(ros: both.Both) -> None:
    pose1 = genpy_class(ros, "geometry_msgs/PoseStamped")
    with both.Bridge(RULE):
        out1 = rospy.Publisher("/pose1", pose1, queue_size=1, latch=True)
        sent = pose1()
        sent.pose.position.z, sent.pose.orientation.w = 1.5, 1.0
        out1.publish(sent)
        recorder2 = ros.hear2("/pose1", TransformStamped, latched=True)
        assert recorder2.wait()[0].transform.translation.z == 1.5
        out2 = ros.node.create_publisher(TransformStamped, "/pose2", 1)
        recorder1 = ros.hear1("/pose2", "geometry_msgs/PoseStamped")
        message = recorder2.heard[0]
        wait_until(lambda: out2.publish(message) or recorder1.heard, lambda: "nothing is heard")
        back = pose1().deserialize(recorder1.heard[0]._buff)
        assert (back.pose.position.z, back.pose.orientation.w) == (1.5, 1.0)
        recorder1.end(), recorder2.end()
        out1.unregister()
        ros.node.destroy_publisher(out2)


def test_bridge_with_a_rule_that_does_not_fit_ends_with_the_reason(ros: both.Both) -> None:
    both.end_shared_bridge()
    rule = RULE.replace("child_frame_id", "child_frame")
    with both.Running("ros2_bridge", "bridge", rule) as bridge:
        assert bridge.wait() == 1
        (line,) = [line for line in bridge.logged() if "parameter mappings" in line]
    assert "geometry_msgs/TransformStamped has no field child_frame" in line
    assert not any("Traceback" in line for line in bridge.logged())


def test_draft_is_a_rule_that_the_bridge_accepts(ros: both.Both) -> None:
    names = ("geometry_msgs/PoseStamped", "geometry_msgs/msg/TransformStamped")
    with both.Running("ros2_bridge", "bridge", "--draft-mapping", *names) as draft:
        assert draft.wait() == 0
        printed = draft.logged()
    assert printed[:3] == ["mappings:", f"- ros1: {names[0]}", f"  ros2: {names[1]}"]
    assert "    - child_frame_id" in printed
    with both.Running("ros2_bridge", "bridge", "--draft-mapping", "a/B") as refused:
        assert refused.wait() == 1
        assert "needs a ROS 1 type and a ROS 2 type" in refused.logged()[-1]


def test_print_pairs_applies_the_rules_in_a_file(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "mappings.yaml"

    def printed(text: str) -> both.Running:
        file.write_text(text)
        with both.Running("ros2_bridge", "bridge", "--print-pairs", str(file)) as command:
            command.wait()
        return command

    command = printed(f"mappings: {RULE.partition(':=')[2]}\n")
    assert command.popen.returncode == 0
    assert "geometry_msgs/PoseStamped <=> geometry_msgs/msg/TransformStamped" in command.lines
    assert "std_srvs/Trigger <=> std_srvs/srv/Trigger" in command.lines
    for text, why in (
        ("mappings: [{ros1: geometry_msgs/Pose, ros2: geometry_msgs/msg/Point}]", "orientation"),
        (
            "mappings: [{ros1: acme_msgs, ros2: nowhere_msgs}]",
            "acme_msgs is not installed in ROS 1",
        ),
        ("rules: []", "must contain mappings, a list of rules, and nothing else"),
        ("mappings: [", "while parsing"),
    ):
        command = printed(text)
        assert (command.popen.returncode, command.lines) == (1, [])
        assert command.error_lines[0].startswith("bridge: --print-pairs: ")
        assert why in " ".join(command.error_lines)
        assert not any("Traceback" in line for line in command.error_lines)


def test_arguments_that_name_no_rules_or_types_are_refused(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(bridge_node, "end", sys.exit)
    nothing = ("geometry_msgs/Nothing", "geometry_msgs/msg/Pose")
    for function, given, why in (
        (bridge_node.print_pairs, ["a.yaml", "b.yaml"], "unexpected argument b.yaml; give at most"),
        (bridge_node.print_pairs, ["/nowhere.yaml"], "No such file or directory: '/nowhere.yaml'"),
        (bridge_node.print_draft, ["std_msgs", "acme_msgs"], "a draft is of a rule for types"),
        (bridge_node.print_draft, [*nothing], "geometry_msgs/Nothing is not installed in ROS 1"),
        (bridge_node.print_draft, [*nothing, "x"], "needs a ROS 1 type and a ROS 2 type"),
    ):
        with pytest.raises(SystemExit, match=f"^bridge: --(print-pairs|draft-mapping).*{why}"):
            function(given)


def test_file_with_more_than_rules_is_refused(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "settings.yaml"
    file.write_text("mappings: []\nallow: ['/arm/*']\n")
    with pytest.raises(ValueError, match="must contain mappings, a list of rules, and nothing"):
        read_rules(str(file))
