"""Topics that several nodes latch: a late subscriber gets the latest of each.

As of a robot: its description, and the static transforms of two nodes.
"""

import struct
from types import SimpleNamespace
from typing import Any, List

import both
import rospy
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from std_msgs.msg import String
from test_topics import publisher1
from tf2_msgs.msg import TFMessage

from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.selection import Rules
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.topics.robot_description import RobotDescription

TF, DESCRIPTION = "/tf_static", "/robot_description"
TF1 = "tf2_msgs/TFMessage"
QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROBOT = "<robot name='bot'/>"


def tf1(child: str) -> bytes:
    """Return the bytes in ROS 1 of a transform to a frame."""
    frames = b"".join(struct.pack("<I", len(name)) + name.encode() for name in ("map", child))
    return struct.pack("<IIII", 1, 0, 7, 8) + frames + struct.pack("<7d", *range(7))


def tf2(child: str) -> Any:
    """Return a message in ROS 2 of a transform to a frame."""
    return TFMessage(transforms=[TransformStamped(child_frame_id=child)])


def frames(ros: both.Both, recorder: both.MessageRecorder) -> List[str]:
    """Return the frames that were heard, in either ROS."""
    codec = ros.types.message(TF1).codec
    found = [
        heard
        if isinstance(heard, TFMessage)
        else deserialize_message(codec.to_cdr(heard._buff), TFMessage)
        for heard in list(recorder.heard)
    ]
    return [message.transforms[0].child_frame_id for message in found]


def publishers1(topic: str) -> List[str]:
    """Return the nodes that publish a topic in ROS 1."""
    published = rospy.get_master().getSystemState()[2][0]
    return dict(published).get(topic, [])


def wait_for(ros: both.Both, recorder: both.MessageRecorder, *names: str) -> None:
    wait_until(lambda: {*names} <= {*frames(ros, recorder)}, lambda: str(frames(ros, recorder)))


def late1(ros: both.Both, *names: str) -> List[str]:
    """Return the frames that a late ROS 1 listener receives, once it has these."""
    recorder = ros.hear1(TF, TF1)
    wait_for(ros, recorder, *names)
    rospy.sleep(0.3)  # what is too much would have come by now
    recorder.end()
    return sorted(frames(ros, recorder))


def test_late_ros1_listeners_get_latched_message_of_each_ros2_node(ros: both.Both) -> None:
    left, right = (ros.node.create_publisher(TFMessage, TF, QOS) for _ in range(2))
    description = ros.node.create_publisher(String, DESCRIPTION, QOS)
    description.publish(String(data=ROBOT))
    for child in ("older", "old", "left"):
        left.publish(tf2(child))
    right.publish(tf2("right"))
    with both.Bridge():
        early = ros.hear1(TF, TF1)
        wait_for(ros, early, "left", "right")
        early.end()  # or the next one would share its connection
        assert late1(ros, "left", "right") == ["left", "right"]
        text = ros.hear1(DESCRIPTION, "std_msgs/String")
        assert text.wait()[0]._buff[4:].decode() == ROBOT
        text.end()
    with both.Bridge():
        both_of_them = ["left", "right"]
        wait_until(lambda: late1(ros, *both_of_them) == both_of_them, lambda: "not each once")
        ros.node.destroy_publisher(right)
        wait_until(lambda: late1(ros, "left") == ["left"], lambda: str(late1(ros, "left")))
    for publisher in (left, description):
        ros.node.destroy_publisher(publisher)


def test_volatile_ros2_node_keeps_latched_message_of_another(
    ros: both.Both,
) -> None:
    left = ros.node.create_publisher(TFMessage, TF, QOS)
    left.publish(tf2("left"))
    with both.Bridge():
        # Who subscribes in the moment in which another one begins to publish connects to it twice
        # at times, by rospy, and gets twice what it latches.
        wait_until(lambda: publishers1(TF), lambda: "the bridge does not publish it")
        early = ros.hear1(TF, TF1)
        wait_for(ros, early, "left")
        plain = ros.node.create_publisher(TFMessage, TF, 10)

        def is_heard(child: str) -> bool:
            plain.publish(tf2(child))
            return child in frames(ros, early)

        for child in ("new", "left"):
            wait_until(lambda: is_heard(f"not {child}"), lambda: str(frames(ros, early)))
            left.publish(tf2(child))
        wait_until(lambda: frames(ros, early).count("left") == 2, lambda: str(frames(ros, early)))
        wait_until(lambda: is_heard("last"), lambda: str(frames(ros, early)))
        latched = [one for one in frames(ros, early) if one in ("left", "new")]
        assert latched == ["left", "new", "left"]  # each once
        early.end()
        assert late1(ros, "left") == ["left"]
        ros.node.destroy_publisher(plain)
        assert late1(ros, "left") == ["left"]
    ros.node.destroy_publisher(left)


def test_late_ros2_listeners_get_no_outdated_message(ros: both.Both) -> None:
    out = publisher1(ros, DESCRIPTION, "std_msgs/String", latch=True)
    plain = publisher1(ros, "/plain", "std_msgs/String")

    def listen(text: str) -> str:
        """Latch a text, and return the first message of a late listener."""
        out.send(struct.pack("<I", len(text)) + text.encode())
        recorder, other = ros.hear2(DESCRIPTION, String, latched=True), ros.hear2("/plain", String)
        first = recorder.wait()[0].data
        wait_until(plain.get_num_connections, lambda: "the bridge does not listen")
        for one in (recorder, other):
            one.end()
        wait_until(lambda: not plain.get_num_connections(), lambda: "the bridge goes on to listen")
        return str(first)

    with both.Bridge():
        assert listen("old") == "old"
        assert listen("new") == "new"
    for publisher in (out, plain):
        publisher.unregister()


def test_late_ros2_listeners_get_latched_message_of_each_ros1_node(ros: both.Both) -> None:
    left = publisher1(ros, TF, TF1, latch=True)
    left.send(tf1("left"))
    description = publisher1(ros, DESCRIPTION, "std_msgs/String", latch=True)
    description.send(struct.pack("<I", len(ROBOT)) + ROBOT.encode())
    right = "transforms: [{child_frame_id: right}]"
    other = Process("/usr/bin/rostopic", ["pub", "--latch", TF, TF1, right])
    try:
        with both.Bridge():
            early = ros.hear2(TF, TFMessage, latched=True)
            wait_for(ros, early, "left", "right")
            before = frames(ros, early).count("left")
            for child in ("new", "left"):
                left.send(tf1(child))
            wait_until(
                lambda: frames(ros, early).count("left") > before,
                lambda: str(frames(ros, early)),
            )
            late = ros.hear2(TF, TFMessage, latched=True)
            wait_for(ros, late, "left", "right")
            rospy.sleep(0.3)  # what is too much would have come by now
            assert sorted(frames(ros, late)) == ["left", "right"]
            text = ros.hear2(DESCRIPTION, String, latched=True)
            assert text.wait()[0].data == ROBOT
            for recorder in (early, late, text):
                recorder.end()
    finally:
        other.end()
    for publisher in (left, description):
        publisher.unregister()


def test_robot_description_of_the_parameter_server_is_latched_in_ros2(
    ros: both.Both, bridge: both.Bridge
) -> None:
    def heard(recorder: both.MessageRecorder) -> List[str]:
        return [message.data for message in recorder.heard]

    rospy.set_param(DESCRIPTION, ROBOT)
    early = ros.hear2(DESCRIPTION, String, latched=True)
    wait_until(lambda: heard(early) == [ROBOT], lambda: str(heard(early)))
    rospy.set_param(DESCRIPTION, "<robot name='ü'/>")
    wait_until(lambda: heard(early)[-1:] == ["<robot name='ü'/>"], lambda: str(heard(early)))
    late = ros.hear2(DESCRIPTION, String, latched=True)
    wait_until(lambda: heard(late) == ["<robot name='ü'/>"], lambda: str(heard(late)))

    def publishers() -> List[str]:
        return [one.node_name for one in ros.node.get_publishers_info_by_topic(DESCRIPTION)]

    # A node of ROS 2 that publishes one replaces it.
    own = ros.node.create_publisher(String, DESCRIPTION, QOS)
    wait_until(lambda: publishers() == ["ros2_tests"], lambda: str(publishers()))
    ros.node.destroy_publisher(own)
    wait_until(lambda: publishers() == ["ros2_bridge"], lambda: str(publishers()))
    rospy.set_param(DESCRIPTION, 5)
    wait_until(
        lambda: any("/robot_description of ROS 1: not a text" in line for line in bridge.logged()),
        lambda: str(bridge.logged()),
    )
    assert publishers() == []
    rospy.set_param(DESCRIPTION, ROBOT)
    wait_until(lambda: publishers() == ["ros2_bridge"], lambda: str(publishers()))
    rospy.delete_param(DESCRIPTION)
    wait_until(lambda: publishers() == [], lambda: str(publishers()))
    for recorder in (early, late):
        recorder.end()


def test_robot_description_has_its_name_in_ros2_unless_denied(ros: both.Both) -> None:
    keep: List[Any] = []
    node: Any = SimpleNamespace(on_parameter=lambda _, callback, group: keep.append(callback))
    made, ended, sent = [], [], []

    def create(*given: Any) -> Any:
        made.append(given[2])
        return SimpleNamespace(publish=sent.append)

    participant: Any = SimpleNamespace(
        node=None, create_publisher=create, destroy_publisher=lambda *given: ended.append(given)
    )
    description = RobotDescription(node, participant, ros.types, SkipLog())
    keep[0](ROBOT)
    rules, graph = Rules(True, True, ["*"], [], Renaming(["/=/lab"])), Ros1Graph({}, {}, {}, {}, 1)
    for denied in ([DESCRIPTION], [], [DESCRIPTION], [], [DESCRIPTION]):
        description.update(rules._replace(deny=denied), graph, {})
    description.update(rules._replace(to_ros2=False), graph, {})
    assert (made, len(sent), len(ended)) == ([f"/lab{DESCRIPTION}"] * 2, 2, 2)
