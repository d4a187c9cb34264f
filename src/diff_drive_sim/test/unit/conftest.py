"""Selection of tests: that of rviz runs only if rviz is installed, as it is large."""

import shutil

import rospkg


def _is_there() -> bool:
    try:
        rospkg.RosPack().get_path("robot_state_publisher")
    except rospkg.ResourceNotFound:
        return False
    return all(shutil.which(name) for name in ("Xvfb", "rviz"))


collect_ignore = [] if _is_there() else ["test_rviz.py"]
