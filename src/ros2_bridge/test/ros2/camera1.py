"""ROS 1 camera by nodekit for the tests: arrays of 1 MB, each of one number, counted up."""

from std_msgs.msg import UInt8MultiArray

from nodekit import Node, run


class Camera:
    """Publishes at 20 Hz to connected subscribers."""

    def __init__(self, node: Node) -> None:
        self._number = 0
        self._publisher = node.create_publisher("/pictures", UInt8MultiArray, queue_size=10)
        node.create_timer(20.0, self._publish)

    def _publish(self, _time: float) -> None:
        if self._publisher.get_num_connections():
            self._publisher.publish(UInt8MultiArray(data=bytes([self._number % 251]) * 1_000_000))
            self._number += 1


if __name__ == "__main__":
    run("camera1", Camera)
