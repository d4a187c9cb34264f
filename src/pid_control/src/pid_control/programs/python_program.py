"""Start of a Python script with python3 if its mode or its ``#!`` line is unusable."""

import contextlib
import os
import shutil
import sys
from typing import Mapping, Sequence, Tuple

#: Longest first line that is read [bytes]; Linux reads 256.
_LONGEST = 256
#: First bytes of a compiled program.
_ELF = b"\x7fELF"


def start_words(path: str, environment: Mapping[str, str]) -> Tuple[Sequence[str], Sequence[str]]:
    """Return the words that start a program, and a note on each reason to start it with Python.

    :param path: path of the program
    :param environment: environment variables of the program
    """
    line = b""
    with contextlib.suppress(OSError):  # a program need not be readable
        with open(path, "rb") as file:
            line = file.readline(_LONGEST)
    if line.startswith(_ELF):
        return [path], []
    if not path.endswith(".py") and not (line.startswith(b"#!") and b"python" in line):
        return [path], []
    problems = []
    if not os.access(path, os.X_OK):
        problems.append("not executable")
    if not line.startswith(b"#!"):
        problems.append("the first line does not begin with #!")
    elif line.endswith(b"\r\n"):
        problems.append("the first line ends with CR LF, as on Windows")
    if line.startswith(b"#!"):
        interpreter, _, argument = line[2:].decode(errors="replace").strip().partition(" ")
        if os.path.basename(interpreter) == "env" and os.access(interpreter, os.X_OK):
            words = argument.split() if argument.startswith("-") else [argument.strip()]
            interpreter = next((word for word in words if word[:1] != "-" and "=" not in word), "")
        found = shutil.which(interpreter, path=environment.get("PATH"))
        if found is None:
            problems.append(f"interpreter not found ({interpreter})")
        elif os.path.realpath(found) != os.path.realpath(sys.executable):
            problems.append(f"not the Python of ROS ({found})")
    if not problems:
        return [path], []
    # The Python of this process has rospy.
    notes = [f"{path}: {problem}; started with python3" for problem in problems]
    return [sys.executable, path], notes
