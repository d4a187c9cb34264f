"""Topics, both ways."""

import struct
from typing import Any

import rospy
from basic_comms.msg import SignalMsg
from std_msgs.msg import Float32, String

import both
from nodekit.testing.waiting import wait_until


def publisher1(ros: both.Both, topic: str, kind: str, latch: bool = False) -> Any:
    raw = ros.types.message(kind).raw
    made = rospy.Publisher(topic, raw, queue_size=1000, latch=latch)

    def publish(data: bytes) -> None:
        message = raw()
        message._buff = data
        made.publish(message)

    made.send = publish
    return made


def test_signal_arrives_with_four_right_fields(ros: both.Both, bridge: both.Bridge) -> None:
    out = publisher1(ros, "/signal", "basic_comms/signal_msg")
    wait_until(lambda: ros.node.count_publishers("/signal"), lambda: "no /signal in ROS 2")
    ear = ros.hear2("/signal", SignalMsg)
    wait_until(lambda: out.get_num_connections(), lambda: "the bridge does not listen")
    for number in range(3):
        out.send(struct.pack("<ffdf", 2.0, 6.25, 0.1 * number, -1.5))
    first, _, last = ear.wait(3)
    assert (first.amplitude, first.frequency, first.signal_y) == (2.0, 6.25, -1.5)
    assert last.time_x == 0.1 * 2
    ear.end()
    wait_until(lambda: not out.get_num_connections(), lambda: "the bridge goes on to listen")
    out.unregister()
    wait_until(lambda: not ros.node.count_publishers("/signal"), lambda: "/signal stays")


def test_text_arrives_in_ros1(ros: both.Both, bridge: both.Bridge) -> None:
    out = ros.node.create_publisher(String, "/chatter", 10)
    ear = ros.hear1("/chatter", "std_msgs/String")
    wait_until(lambda: out.get_subscription_count(), lambda: "the bridge does not listen")
    out.publish(String(data="grüezi"))
    (message,) = ear.wait()
    assert message._buff == struct.pack("<I", 7) + "grüezi".encode()
    assert message._connection_header["type"] == "std_msgs/String"
    ear.end()
    ros.node.destroy_publisher(out)


def test_latched_topics_stay_latched(ros: both.Both, bridge: both.Bridge) -> None:
    latched = publisher1(ros, "/level1", "std_msgs/Float32", latch=True)
    latched.send(struct.pack("<f", 2.5))
    for _ in range(2):  # who comes later gets it too
        ear = ros.hear2("/level1", Float32, latched=True)
        assert ear.wait()[0].data == 2.5
        ear.end()
    from rclpy.qos import DurabilityPolicy, QoSProfile

    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    out = ros.node.create_publisher(Float32, "/level2", qos)
    out.publish(Float32(data=3.5))
    for _ in range(2):
        ear = ros.hear1("/level2", "std_msgs/Float32")
        assert ear.wait()[0]._buff == struct.pack("<f", 3.5)
        ear.end()
    latched.unregister()
    ros.node.destroy_publisher(out)


def test_a_topic_of_both_sides_has_no_echo(ros: both.Both, bridge: both.Bridge) -> None:
    out1 = publisher1(ros, "/both", "std_msgs/Float32")
    out2 = ros.node.create_publisher(Float32, "/both", 100)
    ear1, ear2 = ros.hear1("/both", "std_msgs/Float32"), ros.hear2("/both", Float32)
    wait_until(lambda: out1.get_num_connections() == 2, lambda: "nobody listens in ROS 1")
    wait_until(lambda: out2.get_subscription_count() == 2, lambda: "nobody listens in ROS 2")
    for number in range(10):
        out1.send(struct.pack("<f", number))
        out2.publish(Float32(data=100.0 + number))
    numbers = {float(number) for number in range(10)}
    both_kinds = numbers | {100.0 + number for number in numbers}
    ear1.wait(20), ear2.wait(20)
    rospy.sleep(0.3)  # what is too much would have come by now
    assert sorted(message.data for message in ear2.heard) == sorted(both_kinds)
    assert sorted(struct.unpack("<f", m._buff)[0] for m in ear1.heard) == sorted(both_kinds)
    for ear in (ear1, ear2):
        ear.end()
    out1.unregister()
    ros.node.destroy_publisher(out2)
