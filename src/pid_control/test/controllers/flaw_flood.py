#!/usr/bin/env python3
"""A loop without rospy.Rate."""

import rospy

from student import Student, main


class Flood(Student):
    def run(self) -> None:
        before = self.now()
        while not rospy.is_shutdown():
            now = self.now()
            self.send(self.law(self.set_point - self.output, now - before))
            before = now


if __name__ == "__main__":
    main(Flood)
