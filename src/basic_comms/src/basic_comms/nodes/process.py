"""Scale and shift the signal (walking skeleton: no phase shift yet)."""

import rospy
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg


def main() -> None:
    """Run the node until it is shut down."""
    rospy.init_node("process")
    scale = rospy.get_param("~amplitude_scale", 0.5)
    publisher = rospy.Publisher("proc_signal", Float32, queue_size=10)
    rospy.Subscriber(
        "signal", signal_msg, lambda message: publisher.publish(scale * message.signal_y)
    )
    rospy.spin()
