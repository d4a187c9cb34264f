"""In which order a process ends, with a process that does, and no master."""

import subprocess
import sys

ENDS = """
from functools import partial
import rospy

def fail():
    raise ValueError("on purpose")

rospy.on_shutdown(partial(print, "rospy's first"))
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
rospy.on_shutdown(partial(print, "rospy's second"))
for ending in (ShutdownPhase.TOOLKIT, ShutdownPhase.NODES, ShutdownPhase.TRANSITIONS):
    for number in (1, 2):
        at_end(ending, partial(print, ending.name, number))
at_end(ShutdownPhase.NODES, fail)
forget = at_end(ShutdownPhase.NODES, partial(print, "forgotten"))
forget()
rospy.signal_shutdown("the test is over")
at_end(ShutdownPhase.TOOLKIT, partial(print, "too late"))
at_end(ShutdownPhase.NODES, partial(print, "much too late"))
"""


def test_what_nodes_ask_for_comes_first_and_the_latest_before_the_others() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", ENDS],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert ended.returncode == 0, ended.stderr
    ours = "NODES 2, NODES 1, TRANSITIONS 2, TRANSITIONS 1, TOOLKIT 2, TOOLKIT 1".split(", ")
    assert ended.stdout.splitlines() == [*ours, "rospy's first", "rospy's second", "too late"]
    assert "ValueError: on purpose" in ended.stderr
