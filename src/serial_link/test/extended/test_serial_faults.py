#!/usr/bin/env python3
"""A board with a motor behind the node: faults of cables, boards, ports and the master."""

import os
import shutil
import time
from typing import Dict, List

import rospkg
import rospy
from helpers.node_rig import SCRIPTS, NodeRig
from pid_control.msg import motor_input, motor_output
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Master, Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class SerialFaults(NodeRig):
    """Faults, and a check of the controller that takes the board for its plant."""

    def test_controller_check_takes_the_board_for_a_plant(self) -> None:
        """The verdict may be that the machine is too busy; the motor moves and stops anyway."""
        self.start_both(gain=26.2, max_speed=26.0)
        inputs = MessageRecorder(self.space + "/motor_input", motor_input)
        package = rospkg.RosPack().get_path("pid_control")
        words = ["--real-plant", "--full-speed", "26", "--only", "ramp"]
        controller = os.path.join(package, "launch", "pid_real.launch")
        command = os.path.join(package, "scripts", "judge")  # of pid_control
        for _ in range(3):
            node = Process(command, [*words, controller], {"ROS_NAMESPACE": self.space})
            self.addCleanup(node.end)
            node.popen.wait(4 * TIMEOUT_S)  # it has its own limit
            if not node.logged("the plant is silent"):  # as a board is on a busy machine
                break
        said = {0: "passed: all 2 figures of 1 scenario", 125: "this machine is too busy"}
        self.assertTrue(node.logged(said.get(node.wait(), "?")), node.logged())
        # The ramp goes to 9 rad/s of 13, and this motor is twice as fast.
        self.assertGreater(max(heard.output for heard in self.outputs.messages()), 14.0)
        wait_until(
            lambda: inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {inputs.messages()[-1]}",
        )
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")

    def test_noise_is_counted_and_what_comes_through_is_whole(self) -> None:
        link = self.start_both()
        self.set(noise=0.01)
        self.outputs.clear()
        self.wait_for_figure("fault: checksum", 30)
        heard = [message.status for message in self.outputs.messages()]
        self.set(noise=0.0)
        self.wait_until_back(time.monotonic())
        statuses = {"Motor Not Turning", "Motor Turning", "Motor Max Speed"}
        self.assertTrue(heard)
        # One in three was damaged. Of these, one in a thousand has valid checksums all the same.
        wrong = [status for status in heard if status not in statuses]
        self.assertLessEqual(len(wrong), 2 + len(heard) / 100, wrong)
        link.wait_for_log("frames received", "fault: checksum")
        # Hundreds of garbage bytes are logged in one or two lines, not in one each.
        self.assertLess(len(link.lines) + len(link.error_lines), 40)

    def test_board_that_floods_holds_up_nothing(self) -> None:
        buttons = MessageRecorder(self.space + "/button", Bool)
        self.start_both(floods=True)
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: self.outputs.count() > 200)
        self.set(button=True)
        buttons.wait_for(lambda heard: heard.data)
        call = rospy.ServiceProxy(self.space + "/zero_encoder", Trigger)
        call.wait_for_service(TIMEOUT_S)
        self.assertTrue(call().success)

    def test_another_md5sum_is_refused_in_words_and_other_topics_work(self) -> None:
        buttons = MessageRecorder(self.space + "/button", Bool)
        self.start_board(wrong_md5="motor_output")
        link = self.start_link()
        buttons.wait_for(lambda heard: True)
        link.wait_for_log(
            "motor_output is refused: pid_control/motor_output differs on the board",
            motor_output._md5sum[::-1],
            motor_output._md5sum,
            "generate the sketch's headers again",
        )
        self.wait_for_figure("of refused topics")
        self.assertEqual(self.outputs.count(), 0)
        self.set(wrong_md5="")
        rospy.ServiceProxy(self.space + "/simulated_board/reset", Trigger)()
        self.outputs.wait_for(lambda heard: True)

    def test_stalled_board_is_back_when_it_goes_on(self) -> None:
        self.start_both()
        self.set(stalled=True)
        call = rospy.ServiceProxy(self.space + "/zero_encoder", Trigger)
        call.wait_for_service(TIMEOUT_S)
        change(self.space + "/serial_node", service_timeout=0.2)
        with self.assertRaisesRegex(rospy.ServiceException, "has not answered within 0.2 s"):
            call()
        self.set(stalled=False)
        self.wait_until_back(time.monotonic())
        change(self.space + "/serial_node", service_timeout=5.0)
        self.assertTrue(call().success)

    def test_second_node_says_who_holds_the_port(self) -> None:
        first = self.start_both()
        second = self.start("serial_node", "__name:=second", port=self.port)
        second.wait_for_log(f"{self.port} is in use by process {first.popen.pid}", "serial_node.py")
        self.assertEqual(first.interrupt(), 0)
        # It opens the port as soon as the first board is gone.
        self.wait_until_back(time.monotonic())

    def test_second_board_does_not_take_the_place_of_the_first(self) -> None:
        first = self.start_board()
        wait_until(lambda: os.path.islink(self.port), lambda: "no port")
        second = self.start("simulated_board", "__name:=second", link=self.port)
        self.assertEqual(second.wait(), 1)
        second.wait_for_log("the board's port cannot be created", self.port)
        self.assertFalse(second.logged("Traceback"))
        self.assertEqual(first.interrupt(), 0)
        self.assertFalse(os.path.islink(self.port))

    def test_port_that_is_none_is_refused(self) -> None:
        for parameters, said in (
            ({"port": "''"}, "port must be the path"),
            ({"baud": 0}, "baud: refused 0: must be a whole number in [2400, 4000000]"),
        ):
            node = self.start_link(**parameters)
            self.assertEqual(node.wait(), 1)
            node.wait_for_log(said)

    def test_restarted_master_finds_the_board_again(self) -> None:
        master = Master()
        self.addCleanup(master.kill)
        environment = {"ROS_MASTER_URI": master.uri}

        def start(name: str, *words: str) -> Process:
            script = os.path.join(SCRIPTS, name + ".py")
            process = Process(script, list(words), environment)
            self.addCleanup(process.end)
            return process

        start("simulated_board", f"_link:={self.port}", "_baud:=115200")
        start("serial_node", f"_port:={self.port}", "_baud:=115200")
        listen = ["topic", "echo", "-n", "3", "/motor_output"]
        self.assertIn("status:", self.shell(environment, listen))
        master.kill()
        master.start()
        self.assertIn("status:", self.shell(environment, listen))

    def shell(self, environment: Dict[str, str], words: List[str]) -> str:
        """Run a ROS command; return its output."""
        program = shutil.which("ros" + words[0])
        assert program is not None
        process = Process(program, words[1:], environment)
        self.addCleanup(process.end)
        self.assertEqual(process.wait(), 0)
        return "\n".join(process.lines)


if __name__ == "__main__":
    rospy.init_node("test_serial_faults")
    rosrun("serial_link", "serial_faults", SerialFaults)
