#!/usr/bin/env python3
"""The workspace's own nodes, managed: silent until they are active, as ever without it."""

import time
import unittest

import rospy
from rosgraph_msgs.msg import Log
from roslib.packages import find_node
from std_msgs.msg import Float32, String

from basic_comms.msg import signal_msg
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

SPACE = "/lab"
#: Topic of each node.
OUTPUTS = {
    "signal_generator": ("signal", signal_msg),
    "process": ("proc_signal", Float32),
    "first_order_sys": ("output", Float32),
    "motor_sys": ("motor_speed_y", Float32),
}
#: Several periods of each node [s].
SILENCE_S = 0.4


class ManagedNodes(unittest.TestCase):
    """The four nodes of a launch file in its namespace, and their messages."""

    def change(self, node: str, label: str) -> bool:
        service = rospy.ServiceProxy(f"{SPACE}/{node}/change_state", ChangeState)
        return bool(service(Transition(0, label)).success)

    def change_all(self, label: str) -> None:
        for node in OUTPUTS:
            self.assertTrue(self.change(node, label), node)

    def state(self, node: str) -> str:
        answer = rospy.ServiceProxy(f"{SPACE}/{node}/get_state", GetState)()
        return str(answer.current_state.label)

    def test_four_nodes(self) -> None:
        with launched(
            f"basic_comms signal_gen.launch managed:=true __ns:={SPACE}",
            f"basic_comms process.launch managed:=on __ns:={SPACE}",
            f"first_order_sys_sim system.launch managed:=yes __ns:={SPACE}",
            f"motor_control motor.launch managed:=1 __ns:={SPACE}",
            "lifecycle_demo lifecycle_aware_node.launch robot_name:=marvin "
            f"wait_for_manager:=on __ns:={SPACE}",
            f"lifecycle_demo example_node.launch rate:=5 __ns:={SPACE}",
        ) as launch:
            self.graph = launch.graph
            self.recorders = {
                node: MessageRecorder(f"{SPACE}/{topic}", kind)
                for node, (topic, kind) in OUTPUTS.items()
            }
            self.motor_state = MessageRecorder(f"{SPACE}/motor_state", String)
            self.log = MessageRecorder("/rosout", Log)
            for node in (*OUTPUTS, "lifecycle_aware_node"):
                rospy.wait_for_service(f"{SPACE}/{node}/change_state", TIMEOUT_S)
            self.check_demos()
            self.check_unconfigured()
            self.check_configure()
            self.check_activate()
            self.check_deactivate_and_cleanup()

    def check_demos(self) -> None:
        for label in ("configure", "activate"):
            self.assertTrue(self.change("lifecycle_aware_node", label))
        self.log.wait_for(lambda line: line.msg == "marvin: heartbeat")
        self.log.wait_for(lambda line: line.msg == "Info message")
        self.assertEqual(self.graph.parameter(f"{SPACE}/example_node/rate"), 5.0)

    def check_unconfigured(self) -> None:
        for node, (topic, _) in OUTPUTS.items():
            self.assertEqual(self.state(node), "unconfigured")
            self.assertEqual(self.graph.publishers(f"{SPACE}/{topic}"), set())
            self.assertNotIn(f"{SPACE}/{node}/describe", Server().services())
        self.assertNotIn(f"{SPACE}/sp_gen/get_state", Server().services())

    def check_configure(self) -> None:
        amplitude = f"{SPACE}/signal_generator/amplitude"
        Server().set(amplitude, "much")
        self.assertFalse(self.change("signal_generator", "configure"))
        sentence = f"parameter {amplitude}: refused 'much': must be a number"
        self.log.wait_for(lambda line: sentence in line.msg and "Traceback" not in line.msg)
        self.assertEqual(self.state("signal_generator"), "unconfigured")
        Server().set(amplitude, 3.0)
        self.change_all("configure")
        for node in OUTPUTS:
            self.wait_until_heard(node)
        time.sleep(SILENCE_S)
        self.assert_silent()
        self.assertEqual(self.motor_state.count(), 0)

    def wait_until_heard(self, node: str) -> None:
        topic = f"{SPACE}/{OUTPUTS[node][0]}"
        self.graph.wait_until_heard(f"{SPACE}/{node}", topic, rospy.get_name())

    def assert_silent(self) -> None:
        self.assertEqual(
            {node: recorder.messages()[:1] for node, recorder in self.recorders.items()},
            dict.fromkeys(OUTPUTS, []),
        )

    def wait_until_silent(self) -> None:
        """Wait until no message has arrived for several periods."""
        counts, since = [-1], time.monotonic()

        def is_silent() -> bool:
            nonlocal counts, since
            before, counts = counts, [recorder.count() for recorder in self.recorders.values()]
            if counts != before:
                since = time.monotonic()
            return time.monotonic() - since > SILENCE_S

        wait_until(is_silent, lambda: f"they go on: {counts}")

    def check_activate(self) -> None:
        self.change_all("activate")
        first = self.recorders["signal_generator"].wait_for(lambda sample: True)
        self.assertEqual((first.time_x, first.amplitude), (0.0, 3.0))
        for recorder in self.recorders.values():  # of the motor when its set point has enabled it
            recorder.wait_for(lambda message: True)
        # Latched, and told before: the set point may have enabled the motor when it was inactive.
        self.motor_state.wait_for(lambda state: state.data == "enabled")

    def check_deactivate_and_cleanup(self) -> None:
        self.change_all("deactivate")
        self.wait_until_silent()
        for recorder in self.recorders.values():
            recorder.clear()
        self.change_all("cleanup")
        wait_until(
            lambda: not any(recorder.publishers() for recorder in self.recorders.values()),
            lambda: "a node that is cleaned up is still connected",
        )
        self.assert_silent()
        self.check_unconfigured()
        Server().set(f"{SPACE}/signal_generator/amplitude", 5.0)
        self.assertTrue(self.change("signal_generator", "configure"))
        self.wait_until_heard("signal_generator")
        self.assertTrue(self.change("signal_generator", "activate"))
        again = self.recorders["signal_generator"].wait_for(lambda sample: True)
        self.assertEqual((again.time_x, again.amplitude), (0.0, 5.0))
        self.graph.kill(f"{SPACE}/process")
        wait_until(lambda: not Server().knows(f"{SPACE}/process"), lambda: "process does not end")

    def test_what_is_no_truth_value_is_refused(self) -> None:
        script = find_node("basic_comms", "process.py")[0]
        process = Process(script, ["_managed:=maybe"])
        self.addCleanup(process.end)
        self.assertEqual(process.wait(), 1)
        sentence = "parameter /process/managed: refused 'maybe': must be true or false"
        self.assertTrue(process.logged("[FATAL]", sentence), process.error_lines)
        self.assertFalse(process.logged("Traceback"))


if __name__ == "__main__":
    rospy.init_node("test_managed_nodes")
    rosrun("lifecycle_demo", "managed_nodes", ManagedNodes)
