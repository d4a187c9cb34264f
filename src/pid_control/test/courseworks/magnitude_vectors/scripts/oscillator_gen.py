#!/usr/bin/env python3
"""Signal generator that counts its steps, in a field of a nested message."""

from math import sin

import rospy
from geometry_msgs.msg import Vector3Stamped


def main():
    rospy.init_node("oscillator")
    publisher = rospy.Publisher("input", Vector3Stamped, queue_size=5)
    hz = rospy.get_param("~rate_hz")
    rate = rospy.Rate(hz)
    step = 0
    while not rospy.is_shutdown():
        message = Vector3Stamped()
        message.header.stamp = rospy.Time.now()
        message.vector.x = step / float(hz)
        omega = rospy.get_param("~omega")
        message.vector.y = rospy.get_param("~ampl") * sin(omega * message.vector.x)
        message.vector.z = omega
        publisher.publish(message)
        step += 1
        rate.sleep()


if __name__ == "__main__":
    main()
