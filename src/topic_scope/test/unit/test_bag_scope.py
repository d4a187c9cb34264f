"""Scope of a bag, which is not a node."""

import subprocess
import sys

LOGS = """
import rospy
from topic_scope.web import bag_scope

bag_scope._log_to_terminal()
rospy.loginfo("the scope shows x.bag")
rospy.logwarn("a page is in trouble")
"""


def test_log_is_printed_on_the_terminal() -> None:
    result = subprocess.run(
        [sys.executable, "-c", LOGS], stderr=subprocess.PIPE, universal_newlines=True, timeout=60.0
    )
    said = "[INFO] the scope shows x.bag\n[WARNING] a page is in trouble\n"
    assert (result.returncode, result.stderr) == (0, said)
