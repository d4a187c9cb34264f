#!/usr/bin/env python3
"""Controller with a loop that sleeps by the machine's clock."""

import time

import rospy

from student import Student, main


class Sleeper(Student):
    def run(self) -> None:
        before = time.time()
        while not rospy.is_shutdown():
            now = time.time()
            self.send(self.law(self.set_point - self.output, now - before))
            before = now
            time.sleep(0.01)


if __name__ == "__main__":
    main(Sleeper)
