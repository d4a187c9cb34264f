#!/usr/bin/env python3
"""Controller that waits for 2 s before its first answer."""

import rospy
from student import Student, main


class LateStart(Student):
    def run(self) -> None:
        rospy.sleep(2.0)
        super().run()


if __name__ == "__main__":
    main(LateStart)
