"""Command ``rosrun topic_scope fetch_rosbags.py``: download of the Python library rosbags."""

import argparse
import sys

from nodekit.package_version import ShowVersion
from topic_scope.bag import rosbags_library


def main() -> None:
    """Fetch the library that reads recordings of ROS 2; exit with 0, or 1 if that fails."""
    parser = argparse.ArgumentParser(
        prog="fetch_rosbags",
        description="Fetch the library rosbags, which reads ROS 2 recordings, from PyPI.",
    )
    parser.add_argument("--version", action=ShowVersion, package="topic_scope")
    parser.add_argument("--print", action="store_true", help="print only its path")
    said = "" if parser.parse_args().print else "fetch_rosbags: rosbags is in "
    try:
        print(f"{said}{rosbags_library.fetch()}")
    except rosbags_library.Unavailable as reason:
        sys.exit(f"fetch_rosbags: rosbags cannot be fetched from PyPI: {reason}")
    except OSError as error:
        sys.exit(f"fetch_rosbags: {error.filename}: {error.strerror}")
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C
