"""ROS 1 camera by nodekit for the tests: arrays of 1 MB, each of one number, counted up."""

from std_msgs.msg import UInt8MultiArray

from nodekit import Node, run


#: As many as are held for a subscriber that a busy machine keeps from reading.
PICTURES = 10


class Camera:
    """Publishes some pictures at 20 Hz, once the bridge and the test itself are connected."""

    def __init__(self, node: Node) -> None:
        self._number = 0
        self._publisher = node.create_publisher("/pictures", UInt8MultiArray, queue_size=PICTURES)
        node.create_timer(20.0, self._publish)

    def _publish(self, _time: float) -> None:
        if self._publisher.get_num_connections() == 2 and self._number < PICTURES:
            self._publisher.publish(UInt8MultiArray(data=bytes([self._number]) * 1_000_000))
            self._number += 1


if __name__ == "__main__":
    run("camera1", Camera)
