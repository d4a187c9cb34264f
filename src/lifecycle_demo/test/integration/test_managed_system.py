#!/usr/bin/env python3
"""Generator, process and motor come up in order, and recover after any of them is killed."""

import os
import signal
import unittest

import rospy
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from lifecycle_msgs.srv import GetState
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

NODES = ("/signal_generator", "/process", "/motor_sys")


class ManagedSystem(unittest.TestCase):
    def call(self, name: str, kind: type) -> object:
        rospy.wait_for_service(name, TIMEOUT_S)
        return rospy.ServiceProxy(name, kind)()

    def is_up(self, node: str) -> bool:
        """Return whether a process is active, and with it the system."""
        try:
            state = self.call(node + "/get_state", GetState).current_state.label
            return state == "active" and self.call("/manager/is_active", Trigger).success
        except rospy.ServiceException:  # it is just coming back
            return False

    def test_survives_kill_9_of_any(self) -> None:
        """Each node and the manager is killed in turn."""
        recorder = MessageRecorder("/proc_signal", Float32)
        self.addCleanup(recorder.close)
        with launched("lifecycle_demo managed_system.launch autostart:=ON") as launch:
            for node in NODES:
                wait_until(lambda: self.is_up(node), lambda: f"{node} is not up")
            for node in (*NODES, "/manager"):
                with self.subTest(node=node):
                    before = launch.processes()[node]
                    os.kill(before.pid, signal.SIGKILL)
                    launch.wait_for_new_process(node, before)
                    told = NODES[0] if node == "/manager" else node
                    wait_until(lambda: self.is_up(told), lambda: f"{node} is not back")
                    recorder.clear()
                    recorder.wait_for(lambda message: True)


if __name__ == "__main__":
    rospy.init_node("test_managed_system")
    rosrun("lifecycle_demo", "managed_system", ManagedSystem)
