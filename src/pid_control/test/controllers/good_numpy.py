#!/usr/bin/env python3
"""PI controller with numpy arrays, as the course allows."""

import numpy as np
import rospy

from pid_control.msg import motor_input, motor_output, set_point

gains = np.array([0.05, 1.0])
heard = {"set_point": 0.0, "motor_output": 0.0, "time": 0.0}


def on_set_point(message: set_point) -> None:
    if np.isfinite(message.setPoint):
        heard["set_point"] = message.setPoint


def on_output(message: motor_output) -> None:
    if np.isfinite(message.output):
        heard["motor_output"], heard["time"] = message.output, message.time


rospy.init_node("controller")
publisher = rospy.Publisher("/motor_input", motor_input, queue_size=1)
rospy.Subscriber("/set_point", set_point, on_set_point)
rospy.Subscriber("/motor_output", motor_output, on_output)
rate = rospy.Rate(100)
errors = np.zeros(2)
before = rospy.get_time()
while not rospy.is_shutdown():
    now = rospy.get_time()
    error = heard["set_point"] - heard["motor_output"]
    area = errors[1] + error * (now - before)
    before = now
    # The integral alone stays within the limits.
    errors = np.array([error, np.clip(area, -1.0 / gains[1], 1.0 / gains[1])])
    publisher.publish(float(np.clip(gains @ errors, -1.0, 1.0)), heard["time"])
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
