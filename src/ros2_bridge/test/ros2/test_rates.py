"""Topics are limited to their maximum rate, until the setting changes."""

import struct
from typing import Any, List

import both
import rospy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32
from test_topics import publisher1

from nodekit.testing.waiting import wait_until


def heard(recorder: both.MessageRecorder) -> List[float]:
    """Return the numbers that were heard, in either ROS."""
    found: List[Any] = list(recorder.heard)
    return [
        one.data if isinstance(one, Float32) else struct.unpack("<f", one._buff)[0] for one in found
    ]


def test_rate_is_limited_in_both_directions(ros: both.Both) -> None:
    kept = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    with both.Bridge("_max_rate:=['/quick*=0.01']"):
        out1 = publisher1(ros, "/quick1", "std_msgs/Float32")
        latched1 = publisher1(ros, "/quick_latched1", "std_msgs/Float32", latch=True)
        out2 = ros.node.create_publisher(Float32, "/quick2", 100)
        latched2 = ros.node.create_publisher(Float32, "/quick_latched2", kept)
        limited = [
            ros.hear1("/quick2", "std_msgs/Float32"),
            ros.hear2("/quick1", Float32),
        ]
        latched = [
            ros.hear1("/quick_latched2", "std_msgs/Float32"),
            ros.hear2("/quick_latched1", Float32, latched=True),
        ]
        for made in (out1, latched1):
            wait_until(made.get_num_connections, lambda: "no subscribers in ROS 1")
        for made in (out2, latched2):
            wait_until(made.get_subscription_count, lambda: "no subscribers in ROS 2")

        def send(number: float) -> None:
            for made in (out1, latched1):
                made.send(struct.pack("<f", number))
            for made in (out2, latched2):
                made.publish(Float32(data=number))

        for number in range(20):
            send(float(number))
        for recorder in latched:
            wait_until(lambda: 19.0 in heard(recorder), lambda: str(heard(recorder)))
        rospy.set_param("/ros2_bridge/max_rate", [])
        for recorder in limited:
            wait_until(lambda: send(99.0) or 99.0 in heard(recorder), lambda: str(heard(recorder)))
            # The first ones may be lost: ROS 2 discovers a subscriber before it sends to it.
            assert len([number for number in heard(recorder) if number != 99.0]) <= 1
    for recorder in (*limited, *latched):
        recorder.end()
    for made in (out1, latched1):
        made.unregister()
    for made in (out2, latched2):
        ros.node.destroy_publisher(made)
