#!/usr/bin/env python3
"""A board with a motor behind the node: its topics, a control loop, and recovery."""

import os
import threading
import time

import rospkg
import rospy
from helpers.node_rig import BUSY_S, NodeRig
from pid_control.msg import motor_input, set_point
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool, UInt16
from std_srvs.srv import Trigger

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, free_port
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until


class SerialNode(NodeRig):
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
        # The set point is published once.
        node = Process(controller, ["__ns:=" + self.space, "_command_timeout:=0.0"])
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

    def test_cable_out_and_in_under_another_number(self) -> None:
        link = self.start_both()
        self.set(plugged=False)
        link.wait_for_log(f"{self.port} is gone")
        link.wait_for_log("does not exist: is the board plugged in?")
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
        for number in (1, 2):
            before = len(link.logged(f"{name}: led on"))
            self.assertTrue(reset().success)
            self.wait_until_back(time.monotonic() + 0.2)  # it takes this long to start
            self.wait_for_figure("restarts of the board", number)
            # The board gets latched messages again: it has forgotten them.
            wait_until(
                lambda: len(link.logged(f"{name}: led on")) > before, lambda: str(link.lines)
            )
        log.wait_for(lambda line: (line.name, line.msg) == (name, "led on"))

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
        link = self.start("serial_node", self.port, baud=115200, prot="x", maxpower=3)
        self.outputs.wait_for(lambda heard: True)
        self.assertEqual(rospy.get_param(self.space + "/serial_node/port"), self.port)
        link.wait_for_log("serial_node/prot is not used by this node; did you mean port?")
        self.assertFalse(link.logged("maxpower is not used"))  # a board may ask for it


if __name__ == "__main__":
    rospy.init_node("test_serial_node")
    rosrun("serial_link", "serial_node", SerialNode)
