"""Records when the answers arrive; what is on DDS cannot be read in another way.

Usage: ... RECORD; makes an empty file RECORD.first when the first answer is there.
"""

import pathlib
import sys

import rclpy
from std_msgs.msg import Float32

from record import Record
from spinning import spin_until_interrupted


def main() -> None:
    """Record until interrupted."""
    rclpy.init()
    node = rclpy.create_node("observer")
    record = Record()
    first = True

    def keep(message: Float32) -> None:
        nonlocal first
        record.add(message.data)
        if first:
            first = False
            pathlib.Path(sys.argv[1]).with_suffix(".first").touch()

    node.create_subscription(Float32, "proc_signal", keep, 10)
    spin_until_interrupted(node, lambda: record.write(sys.argv[1]))


if __name__ == "__main__":
    main()
