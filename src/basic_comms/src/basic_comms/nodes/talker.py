"""Publish a line of text again and again."""

import rospy
from std_msgs.msg import String


def main() -> None:
    """Run the node until it is shut down."""
    rospy.init_node("talker")
    publisher = rospy.Publisher("chatter", String, queue_size=10)
    rate = rospy.Rate(rospy.get_param("~rate", 10.0))
    while not rospy.is_shutdown():
        text = "%s %s" % (rospy.get_param("~Message", "hello world"), rospy.get_time())
        rospy.loginfo(text)
        publisher.publish(text)
        rate.sleep()
