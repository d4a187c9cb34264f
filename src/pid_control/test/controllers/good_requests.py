#!/usr/bin/env python3
"""Controller that reads a parameter and logs a line in each iteration: requests to the master."""

import rospy
from student import Student, main


class Talkative(Student):
    def law(self, error: float, dt: float) -> float:
        self.kp = rospy.get_param("~kp", Student.kp)
        value = super().law(error, dt)
        rospy.loginfo("error %g, input %g", error, value)
        return value


if __name__ == "__main__":
    main(Talkative)
