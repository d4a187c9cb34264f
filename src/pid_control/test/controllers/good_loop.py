#!/usr/bin/env python3
"""A loop at 100 Hz, as in the course's skeleton: PI, with dt measured and the integral held."""

from student import Student, main

if __name__ == "__main__":
    main(Student)
