#!/usr/bin/env python3
"""A controller of the motor: P alone."""

import rospy

from pid_control.msg import motor_input, motor_output, set_point


class Controller:
    """Knows the latest set point and output, and answers 100 times a second."""

    def __init__(self) -> None:
        self.kp = rospy.get_param("~kp", 0.08)
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

    def law(self, error: float, dt: float) -> float:
        """Return the input."""
        return max(-1.0, min(1.0, self.kp * error))

    def run(self) -> None:
        rate, before = rospy.Rate(100), rospy.get_time()
        while not rospy.is_shutdown():
            now = rospy.get_time()
            value = self.law(self.set_point - self.output, now - before)
            self.publisher.publish(value, self.time)
            before = now
            rate.sleep()


if __name__ == "__main__":
    rospy.init_node("controller")
    try:
        Controller().run()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
