"""Tests of the order of a process's shutdown, without a master."""

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
for ending in reversed(ShutdownPhase):
    for number in (1, 2):
        at_end(ending, partial(print, ending.name, number))
at_end(ShutdownPhase.NODES, fail)
forget = at_end(ShutdownPhase.NODES, partial(print, "forgotten"))
forget()
rospy.signal_shutdown("the test is over")
at_end(ShutdownPhase.TOOLKIT, partial(print, "too late"))
at_end(ShutdownPhase.NODES, partial(print, "much too late"))
"""


def test_hooks_of_nodes_run_first_and_the_latest_before_earlier_ones() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", ENDS],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert ended.returncode == 0, ended.stderr
    phases = "NODES TRANSITIONS TOOLKIT PUBLISHERS".split()
    ours = [f"{phase} {number}" for phase in phases for number in (2, 1)]
    assert ended.stdout.splitlines() == [*ours, "rospy's first", "rospy's second", "too late"]
    assert "ValueError: on purpose" in ended.stderr


CLIENT_HANGS_UP = """
from types import SimpleNamespace
import rospy
from rospy.impl import tcpros_service
from nodekit.rospy_internals.shutdown import patch_shutdown

patch_shutdown()

def receive_once():
    raise rospy.exceptions.TransportTerminated("unable to receive data from sender")

transport = SimpleNamespace(receive_once=receive_once, close=lambda: print("closed"))
tcpros_service.ServiceImpl.handle(SimpleNamespace(resolved_name="/set"), transport, {})
tcpros_service.logerr("another error")
"""


def test_client_that_hangs_up_before_its_request_causes_no_server_error() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", CLIENT_HANGS_UP],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout == "closed\n"
    assert "another error" in ended.stderr
    assert "incoming connection failed" not in ended.stderr
