#!/usr/bin/env python3
"""A controller of the motor: simple-pid, from PyPI; ~machine_clock lets it go by its own clock."""

import rospy
from simple_pid import PID

from pid_control.msg import motor_input, motor_output, set_point


class Controller:
    """Knows the latest set point and output, and answers 100 times a second."""

    def __init__(self) -> None:
        self.by_machine = rospy.get_param("~machine_clock", False)
        self.pid = PID(0.08, 1.5, rospy.get_param("~kd", 0.0), output_limits=(-1.0, 1.0))
        self.pid.differential_on_measurement = rospy.get_param("~on_measurement", True)
        if not self.by_machine:
            self.pid.sample_time = None
        self.set_point = self.output = self.time = 0.0
        self.publisher = rospy.Publisher("motor_input", motor_input, queue_size=1)
        rospy.Subscriber("set_point", set_point, self.on_set_point)
        rospy.Subscriber("motor_output", motor_output, self.on_output)

    def on_set_point(self, message: set_point) -> None:
        if abs(message.setPoint) < 1e3:  # neither NaN nor infinite
            self.set_point = message.setPoint

    def on_output(self, message: motor_output) -> None:
        if abs(message.output) < 1e3:
            self.output, self.time = message.output, message.time

    def law(self, dt: float) -> float:
        """Return the input."""
        self.pid.setpoint = self.set_point
        if self.by_machine or dt <= 0.0:
            return self.pid(self.output)
        return self.pid(self.output, dt)

    def run(self) -> None:
        rate, before = rospy.Rate(100), rospy.get_time()
        while not rospy.is_shutdown():
            now = rospy.get_time()
            value = self.law(now - before)
            self.publisher.publish(value, self.time)
            before = now
            rate.sleep()


if __name__ == "__main__":
    rospy.init_node("controller")
    try:
        Controller().run()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
