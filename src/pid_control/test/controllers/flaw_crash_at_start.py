#!/usr/bin/env python3
"""Controller that does not start."""

import no_such_module  # noqa: F401
from student import Student, main

if __name__ == "__main__":
    main(Student)
