"""Publish samples of a sine."""

import math

import rospy

from basic_comms.msg import signal_msg
from basic_comms.waveforms import sine


def main() -> None:
    """Run the node until it is shut down."""
    rospy.init_node("signal_generator")
    amplitude = rospy.get_param("~amplitude", 2.0)
    frequency = rospy.get_param("~frequency", 2.0 * math.pi)
    publisher = rospy.Publisher("signal", signal_msg, queue_size=10)
    rate = rospy.Rate(rospy.get_param("~rate", 10.0))
    start = rospy.get_time()
    while not rospy.is_shutdown():
        time_x = rospy.get_time() - start
        publisher.publish(amplitude, frequency, time_x, amplitude * sine(frequency * time_x))
        rate.sleep()
