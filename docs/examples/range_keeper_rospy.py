#!/usr/bin/env python3
"""Keep a robot one metre from a wall, with rospy alone."""

import threading

import rospy
from std_msgs.msg import Float32
from std_srvs.srv import SetBool, SetBoolResponse


class RangeKeeper:
    def __init__(self):
        self.lock = threading.Lock()
        self.gain = rospy.get_param("~gain", 0.5)
        self.range = None
        self.enabled = True
        self.speed = rospy.Publisher("speed", Float32, queue_size=10)
        rospy.Subscriber("range", Float32, self.on_range)
        rospy.Service("~enable", SetBool, self.enable)
        period = rospy.Duration(1.0 / rospy.get_param("~rate", 20.0))
        rospy.Timer(period, self.control)

    def on_range(self, message):
        with self.lock:
            self.range = message.data

    def enable(self, request):
        with self.lock:
            self.enabled = request.data
        return SetBoolResponse(True, "")

    def control(self, event):
        with self.lock:
            if self.enabled and self.range is not None:
                self.speed.publish(self.gain * (self.range - 1.0))


if __name__ == "__main__":
    rospy.init_node("range_keeper")
    RangeKeeper()
    rospy.spin()
