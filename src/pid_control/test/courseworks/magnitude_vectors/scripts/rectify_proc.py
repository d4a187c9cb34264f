#!/usr/bin/env python3
"""Process node that delays the signal by a list, and takes the magnitude."""

import rospy
from geometry_msgs.msg import Vector3Stamped
from std_msgs.msg import Float32


def main():
    rospy.init_node("rectifier")
    late = []
    publisher = rospy.Publisher("output", Float32, queue_size=5)
    delay, gain = rospy.get_param("~phase_samples"), rospy.get_param("~gain")

    def callback(message):
        late.append(message.vector.y)
        if len(late) > delay:
            publisher.publish(gain * abs(late.pop(0)))

    rospy.Subscriber("input", Vector3Stamped, callback)
    rospy.spin()


if __name__ == "__main__":
    main()
