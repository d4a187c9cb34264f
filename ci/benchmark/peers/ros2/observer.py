"""Records when the answers arrive; what is on DDS cannot be read in another way.

Usage: ... RECORD
"""

import sys

import rclpy
from spinning import spin_until_interrupted
from std_msgs.msg import Float32

from ci.benchmark.record import Record


def main() -> None:
    """Record until interrupted."""
    rclpy.init()
    node = rclpy.create_node("observer")
    record = Record(sys.argv[1])
    node.create_subscription(Float32, "proc_signal", lambda got: record.add(got.data), 10)
    spin_until_interrupted(node)


if __name__ == "__main__":
    main()
