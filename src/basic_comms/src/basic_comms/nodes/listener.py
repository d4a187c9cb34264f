"""Log what is heard on chatter."""

import rospy
from std_msgs.msg import String


def main() -> None:
    """Run the node until it is shut down."""
    rospy.init_node("listener")
    rospy.Subscriber("chatter", String, lambda message: rospy.loginfo("I heard %s", message.data))
    rospy.spin()
