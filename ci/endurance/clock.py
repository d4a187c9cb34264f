"""Simulated time: its source in ROS 1, and its use in ROS 2.

Usage: clock.py publish, by rospy, or clock.py use SUMMARY, by rclpy. The simulated time is the
machine's monotonic time, so that each side knows how late it is. The user writes its summary when
it ends.
"""

import contextlib
import json
import pathlib
import sys
import time
from typing import List

RATE = 100.0  # Hz


def publish() -> None:
    """Publish the time at :data:`RATE`, until the process ends."""
    import rospy
    from rosgraph_msgs.msg import Clock

    rospy.init_node("clock")
    publisher = rospy.Publisher("/clock", Clock, queue_size=1)
    with contextlib.suppress(rospy.ROSException):  # the topic is closed at Ctrl-C
        while not rospy.is_shutdown():
            publisher.publish(rospy.Time.from_sec(time.monotonic()))
            time.sleep(1.0 / RATE)


def use(summary: pathlib.Path) -> None:
    """Compare a node's time with the machine's, ten times a second, until the process ends."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.parameter import Parameter

    rclpy.init()
    node = rclpy.create_node(
        "clock_user", parameter_overrides=[Parameter("use_sim_time", value=True)]
    )
    late: List[float] = []

    def compare() -> None:
        if node.get_clock().now().nanoseconds:  # zero before the first message
            late.append(time.monotonic() - 1e-9 * node.get_clock().now().nanoseconds)

    node.create_timer(0.1, compare)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)
    summary.write_text(json.dumps(late))


if __name__ == "__main__":
    if sys.argv[1] == "publish":
        publish()
    else:
        use(pathlib.Path(sys.argv[2]))
