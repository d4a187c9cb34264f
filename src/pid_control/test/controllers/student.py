"""The course's skeleton as a student fills it in: common part of these controllers."""

import math

import rospy

from pid_control.msg import motor_input, motor_output, set_point


class Student:
    """A PI controller in a loop at 100 Hz. Each controller with a flaw overrides one thing."""

    kp, ki, rate = 0.06, 1.2, 100.0

    def __init__(self) -> None:
        self.set_point = self.output = self.integral = 0.0
        self.time = 0.0
        self.publisher = rospy.Publisher("/motor_input", motor_input, queue_size=10)
        rospy.Subscriber("/motor_output", motor_output, self.on_output)
        rospy.Subscriber("/set_point", set_point, self.on_set_point)

    def on_output(self, message: motor_output) -> None:
        if math.isfinite(message.output):
            self.output, self.time = message.output, message.time

    def on_set_point(self, message: set_point) -> None:
        if math.isfinite(message.setPoint):
            self.set_point = message.setPoint

    def now(self) -> float:
        return rospy.get_time()

    def law(self, error: float, dt: float) -> float:
        """Return the input."""
        grown = self.integral + error * dt
        wanted = self.kp * error + self.ki * grown
        if abs(wanted) <= 1.0:
            self.integral = grown
        return max(-1.0, min(1.0, wanted))

    def send(self, value: float) -> None:
        self.publisher.publish(value, self.time)

    def run(self) -> None:
        rate, before = rospy.Rate(self.rate), self.now()
        while not rospy.is_shutdown():
            now = self.now()
            self.send(self.law(self.set_point - self.output, now - before))
            before = now
            try:
                rate.sleep()
            except rospy.ROSInterruptException:
                return


def main(cls: type) -> None:
    rospy.init_node("controller")
    cls().run()
