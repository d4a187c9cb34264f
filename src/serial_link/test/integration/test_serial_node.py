#!/usr/bin/env python3
"""A board with a motor behind the node, and what hardware does to both."""

import os
import shutil
import tempfile
import threading
import time
import unittest
from typing import Any, Dict, List

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from pid_control.msg import motor_input, motor_output, set_point
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool, UInt16
from std_srvs.srv import Trigger

from nodekit.testing.changing import change
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Master, Process, free_port
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until

SCRIPTS = os.path.join(rospkg.RosPack().get_path("serial_link"), "scripts")
#: How soon the board's messages come again [s], and what a busy machine may take on top: together
#: less than the 11 s after which a board notices by itself that the host is gone.
BACK_S, BUSY_S = 1.0, 6.0


class Rig(unittest.TestCase):
    """Each test has a namespace, a board and a node of its own."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.port = os.path.join(self.folder, "by-id", "board")
        self.outputs = MessageRecorder(self.space + "/motor_output", motor_output)

    def start(self, name: str, *words: str, **parameters: Any) -> Process:
        """Start one of the nodes, to be ended after the test."""
        given = [f"_{key}:={value}" for key, value in parameters.items()]
        script = os.path.join(SCRIPTS, name + ".py")
        process = Process(script, ["__ns:=" + self.space, *given, *words])
        self.addCleanup(process.end)
        return process

    def start_board(self, **parameters: Any) -> Process:
        return self.start("simulated_board", **{"link": self.port, "baud": 115200, **parameters})

    def start_link(self, *words: str, **parameters: Any) -> Process:
        return self.start(
            "serial_node", *words, **{"port": self.port, "baud": 115200, **parameters}
        )

    def start_both(self, **parameters: Any) -> Process:
        """Start both, and wait until the motor's speed is heard."""
        self.start_board(**parameters)
        link = self.start_link()
        self.outputs.wait_for(lambda heard: True)
        return link

    def set(self, **values: Any) -> None:
        """Do something to the board."""
        change(self.space + "/simulated_board", **values)

    def wait_until_back(self, since: float) -> None:
        """Wait for another message of the board, which must come in time."""
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: True)
        self.assertLess(time.monotonic() - since, BACK_S + BUSY_S)

    def figures(self) -> Dict[str, int]:
        """Return the node's next figures."""
        name = self.space.lstrip("/") + "/serial_node: board"
        ear = MessageRecorder("/diagnostics", DiagnosticArray)
        heard = ear.wait_for(lambda message: message.status[0].name == name)
        ear.close()
        return {entry.key: int(entry.value) for entry in heard.status[0].values}

    def wait_for_figure(self, name: str, least: int = 1) -> None:
        seen: List[Dict[str, int]] = []

        def is_there() -> bool:
            seen.append(self.figures())
            return seen[-1].get(name, 0) >= least

        wait_until(is_there, lambda: f"{name}: {seen[-1]}")


class SerialNode(Rig):
    """The motor's board behind the node."""

    def test_what_the_board_has_is_on_the_graph_and_the_motor_turns(self) -> None:
        """Course 003-serial-1."""
        buttons = MessageRecorder(self.space + "/button", Bool)
        pots = MessageRecorder(self.space + "/potentiometer", UInt16)
        self.start_both(potentiometer=1.0)
        self.assertEqual(buttons.wait_for(lambda heard: True).data, False)
        self.set(button=True)
        buttons.wait_for(lambda heard: heard.data)
        pots.wait_for(lambda heard: heard.data == 1023)
        publisher = rospy.Publisher(self.space + "/motor_input", motor_input, queue_size=1)
        wait_until(lambda: publisher.get_num_connections(), lambda: "no subscriber of motor_input")
        is_over = threading.Event()

        def drive() -> None:
            while not is_over.wait(0.05):
                publisher.publish(0.5, 0.0)

        thread = in_thread(drive)
        speed = 13.1 * 128 / 255
        turning = self.outputs.wait_for(lambda heard: abs(heard.output - speed) < 0.6)
        self.assertEqual(turning.status, "Motor Turning")
        self.set(gain=6.0)
        self.outputs.wait_for(lambda heard: abs(heard.output - 6.0 * 128 / 255) < 0.6)
        is_over.set()
        thread.join(TIMEOUT_S)
        self.outputs.clear()
        # The sketch stops a motor that gets no input.
        self.outputs.wait_for(lambda heard: heard.output == 0.0)
        call = rospy.ServiceProxy(self.space + "/zero_encoder", Trigger)
        call.wait_for_service(TIMEOUT_S)
        self.assertRegex(call().message, r"^[1-9]\d* counts before$")

    def test_controller_closes_the_loop_over_the_board(self) -> None:
        """Course 003-serial-3."""
        self.start_both()
        controller = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts/controller.py")
        node = Process(controller, ["__ns:=" + self.space])
        self.addCleanup(node.end)
        wanted = rospy.Publisher(self.space + "/set_point", set_point, queue_size=1, latch=True)
        wanted.publish(6.0, 0.0)

        def rests() -> bool:
            latest = [message.output for message in self.outputs.messages()[-50:]]
            return len(latest) == 50 and abs(sum(latest) / 50 - 6.0) < 0.1

        wait_until(rests, lambda: f"outputs are {self.outputs.messages()[-2:]}")
        self.assertEqual(node.interrupt(), 0)
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")

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
            node.popen.wait(4 * TIMEOUT_S)  # it has a limit of its own
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

    def test_cable_out_and_in_under_another_number(self) -> None:
        link = self.start_both()
        self.set(plugged=False)
        link.wait_for_log(f"{self.port} is gone")
        link.wait_for_log("is not there: is the board plugged in?")
        self.set(plugged=True)
        wait_until(lambda: os.path.islink(self.port), lambda: "no port")
        self.wait_until_back(time.monotonic())
        self.assertEqual(self.figures()["openings"], 2)

    def test_board_that_is_reset_in_the_middle_of_a_message(self) -> None:
        # Before it is heard: rospy has a publisher latch only after the master knows it.
        lamp = rospy.Publisher(self.space + "/led", Bool, queue_size=1, latch=True)
        log = MessageRecorder("/rosout", Log)
        lamp.publish(True)
        link = self.start_both(baud=19200, rate=20.0)
        name = self.space + "/serial_node/board"
        link.wait_for_log(f"{name}: led on")
        Graph().wait_until_heard(self.space + "/serial_node", "/rosout", rospy.get_name())
        reset = rospy.ServiceProxy(self.space + "/simulated_board/reset", Trigger)
        for _ in range(2):
            log.clear()
            self.assertTrue(reset().success)
            self.wait_until_back(time.monotonic() + 0.2)  # it takes this long to start
            # The board gets latched messages again: it has forgotten them.
            log.wait_for(lambda line: (line.name, line.msg) == (name, "led on"))
        self.wait_for_figure("restarts of the board", 2)

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
        # One in three was damaged. Of these one in thousands has a sum that holds all the same.
        self.assertLessEqual(len([status for status in heard if status not in statuses]), 1)
        link.wait_for_log("frames received", "fault: checksum")
        # Hundreds of bytes were garbage: they are one line, or two, not one each.
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
            "motor_output is refused: pid_control/motor_output is another one on the board",
            motor_output._md5sum[::-1],
            motor_output._md5sum,
            "make its header for the sketch again",
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
        # It has the port as soon as the first one is gone.
        self.wait_until_back(time.monotonic())

    def test_end_has_the_board_stop_and_says_nothing_more(self) -> None:
        link = self.start_both()
        began = time.monotonic()
        self.assertEqual(link.interrupt(), 0)
        self.assertLess(time.monotonic() - began, 2.0 + BUSY_S)
        self.assertFalse(link.logged("Traceback"))
        self.assertFalse(link.logged("restarted"))
        link = self.start_link()
        self.wait_until_back(time.monotonic() + TIMEOUT_S)

    def test_board_with_wifi_connects_and_comes_back(self) -> None:
        number = free_port()
        self.start_board(link="''", tcp_port=number, baud=0)
        self.start("serial_node", port="tcp", tcp_port=number)
        self.outputs.wait_for(lambda heard: True)
        self.set(plugged=False)
        self.wait_for_figure("no contact", 0)
        self.set(plugged=True)
        self.wait_until_back(time.monotonic())

    def test_port_from_the_command_line_as_rosserial_python_has_it(self) -> None:
        self.start_board()
        self.start("serial_node", self.port, baud=115200)
        self.outputs.wait_for(lambda heard: True)
        self.assertEqual(rospy.get_param(self.space + "/serial_node/port"), self.port)

    def test_port_that_is_none_is_refused(self) -> None:
        for parameters, said in (
            ({"port": "''"}, "port must be the path"),
            ({"baud": 0}, "baud: refused 0: must be a whole number in [2400, 4000000]"),
        ):
            node = self.start_link(**parameters)
            self.assertEqual(node.wait(), 1)
            node.wait_for_log(said)

    def test_second_board_does_not_take_the_place_of_the_first(self) -> None:
        first = self.start_board()
        wait_until(lambda: os.path.islink(self.port), lambda: "no port")
        second = self.start("simulated_board", "__name:=second", link=self.port)
        self.assertEqual(second.wait(), 1)
        second.wait_for_log("the board's port cannot be made", self.port)
        self.assertFalse(second.logged("Traceback"))
        self.assertEqual(first.interrupt(), 0)
        self.assertFalse(os.path.islink(self.port))

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
        """Run one of ROS's commands; return what it prints."""
        program = shutil.which("ros" + words[0])
        assert program is not None
        process = Process(program, words[1:], environment)
        self.addCleanup(process.end)
        self.assertEqual(process.wait(), 0)
        return "\n".join(process.lines)


if __name__ == "__main__":
    rospy.init_node("test_serial_node")
    rosrun("serial_link", "serial_node", SerialNode)
