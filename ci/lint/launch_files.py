"""Check launch files as roslaunch-check does, all in one process.

``launch_files.py FOLDER…`` prints the faults of all launch files below these folders, and ends with
status 1 if there is one, or no launch file is found.
"""

import pathlib
import sys
from typing import Iterator, List

import roslaunch.config
import roslaunch.rlutil


def faults(files: List[pathlib.Path]) -> Iterator[str]:
    """Return a message for each file that cannot be launched or has undeclared dependencies.

    :param files: launch files; test dependencies count as installed, and arguments may be unset
    """
    for file in files:
        fault = roslaunch.rlutil.check_roslaunch(
            str(file), use_test_depends=True, ignore_unset_args=True
        )
        if fault:
            yield f"{file}: {fault}"


def main(folders: List[str]) -> int:
    # roscore's own file, which roslaunch reads with each, starts two commands: 0.3 s a file.
    roslaunch.config.load_roscore = lambda *_, **__: None
    files = [file for folder in folders for file in sorted(pathlib.Path(folder).rglob("*.launch"))]
    found = list(faults(files))
    print("\n".join([*found, f"{len(files)} launch files, {len(found)} of them with faults"]))
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
