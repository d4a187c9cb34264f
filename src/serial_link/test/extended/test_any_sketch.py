#!/usr/bin/env python3
"""Boards of the test's own behind the node: services, parameters, logs, time, and sizes."""

import math
import shutil
import struct
import time
from typing import Any

import rospy
from helpers.board_rig import BUFFER, REQUEST, RESPONSE, BoardRig
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Master, Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from serial_link.board.simulation import Faults
from serial_link.device.rosserial_device import Device
from serial_link.endpoints.types import encode
from serial_link.framing.frames import OLD_REQUEST, PROBE
from serial_link.negotiation.payloads import ERROR, ParameterValues

#: Pause before a parameter is requested again [s]: the node answers within 0.8 s, or not at all.
REPEAT_S = 3.0


class AnySketch(BoardRig):
    """Boards with the test's own sketch."""

    def test_services_both_ways(self) -> None:
        """Course 003-serial-2."""
        called = []

        def answer(request: Any) -> Any:
            called.append(request.data)
            return SetBoolResponse(not request.data, "from ROS")

        service = rospy.Service(self.space + "/called", SetBool, answer)
        self.addCleanup(service.shutdown)
        self.start()
        offered = rospy.ServiceProxy(self.space + "/offered", SetBool)
        offered.wait_for_service(TIMEOUT_S)
        for wanted in (True, False):
            answered = offered(wanted)
            self.assertEqual((answered.success, answered.message), (wanted, "from the board"))
        self.do(lambda device: device.publish("called", encode(REQUEST(True))))
        wait_until(
            lambda: ("called", encode(RESPONSE(False, "from ROS"))) in self.sketch.heard,
            lambda: str(self.sketch.heard),
        )
        self.assertEqual(called, [True])

    def test_calls_that_cannot_be_answered_fail_with_the_reason(self) -> None:
        node = self.start("_service_timeout:=0.3")
        offered = rospy.ServiceProxy(self.space + "/offered", SetBool)
        offered.wait_for_service(TIMEOUT_S)
        self.sketch.answers = False
        with self.assertRaisesRegex(rospy.ServiceException, "not answered within 0.3 s"):
            offered(True)
        self.do(lambda device: device.publish("called", encode(REQUEST(True))))
        node.wait_for_log("the board's call failed", "/called", "no node offers it")
        self.board.faults = Faults(is_plugged=False)
        node.wait_for_log("is gone")
        with self.assertRaisesRegex(rospy.ServiceException, "does not exist|is gone"):
            offered(True)

    def test_types_that_there_are_not_are_refused_and_the_others_work(self) -> None:
        said = MessageRecorder(self.space + "/said", String)
        node = self.start()
        node.wait_for_log("strange is refused: no_such_msgs/Thing not found: is no_such_msgs built")
        node.wait_for_log("stranger is refused: std_msgs/NoSuchThing not found")
        Graph().wait_until_heard(
            self.space + "/serial_node", self.space + "/said", rospy.get_name()
        )
        self.do(lambda device: device.publish("strange", b"x"))
        self.do(lambda device: device.publish("said", encode(String("good"))))
        # Its sums hold, but it is no text: 200 bytes are said to follow.
        self.do(lambda device: device.publish("said", struct.pack("<I", 200) + b"bad"))
        self.do(lambda device: device.publish("said", encode(String("also good"))))
        said.wait_for(lambda heard: heard.data == "also good")
        self.assertEqual([heard.data for heard in said.messages()], ["good", "also good"])

    def test_a_message_beyond_the_buffer_is_not_sent_and_both_sizes_are_told(self) -> None:
        node = self.start()
        publisher = self.publisher()
        wait_until(publisher.get_num_connections, lambda: "the board does not listen")
        publisher.publish("x" * (BUFFER - 4 + 1))
        node.wait_for_log("/told: a message of 101 bytes is not sent", "the board's buffer has 100")
        publisher.publish("x" * (BUFFER - 4))
        self.wait_until_told("x" * (BUFFER - 4))
        self.assertEqual(self.board.device.receiver.too_long, 0)

    def test_a_parameter_beyond_the_buffer_is_answered_by_nothing(self) -> None:
        rospy.set_param(self.space + "/long", "x" * BUFFER)
        rospy.set_param(self.space + "/huge", "x" * 40000)
        node = self.start()
        for name in ("long", "huge"):
            self.request_parameter(name)
        self.assertEqual(
            self.sketch.parameters, [ParameterValues((), (), ()), ParameterValues((), (), ())]
        )
        for name, size in (("long", 116), ("huge", 40016)):
            node.wait_for_log(f"asks for {name}: an answer of {size} bytes", "buffer has 100")
        self.assertEqual(self.board.device.receiver.too_long, 0)

    def test_more_than_the_line_takes_leaves_the_newest(self) -> None:
        self.start()
        stream = self.publisher()
        wait_until(stream.get_num_connections, lambda: "the board does not listen")
        for number in range(1500):
            stream.publish(f"{number:080}")
        self.wait_until_told(f"{1499:080}")
        heard = self.sketch.texts()
        self.assertLess(len(heard), 1500)
        self.assertEqual(heard, sorted(heard))

    def test_what_is_latched_all_comes(self) -> None:
        # Before it is heard: rospy has a publisher latch only after the master knows it.
        latched = self.publisher(latch=True)
        self.start()
        wait_until(latched.get_num_connections, lambda: "the board does not listen")
        texts = [f"latched {number}" for number in range(40)]
        for text in texts:
            latched.publish(text)
        self.wait_until_told(*texts)

    def test_parameters_and_a_log_of_its_own(self) -> None:
        log = MessageRecorder("/rosout", Log)
        rospy.set_param(self.space + "/serial_node/gains", [1, 2.5])
        rospy.set_param(self.space + "/name", "robot")
        rospy.set_param(self.space + "/serial_node/tree", {"a": 1})
        node, name = self.start(), self.space + "/serial_node"
        wait_until(lambda: Graph().initialised(name), lambda: f"{name} does not start")
        Graph().wait_until_heard(name, "/rosout", rospy.get_name())
        for name in ("~gains", "name", "~baud", "~tree", "~missing"):
            self.request_parameter(name)
        self.do(lambda device: device.log(ERROR, "it is hot"))
        self.assertEqual(
            self.sketch.parameters,
            [
                ParameterValues((), (1.0, 2.5), ()),
                ParameterValues((), (), ("robot",)),
                ParameterValues((115200,), (115200.0,), ()),
                ParameterValues((), (), ()),
                ParameterValues((), (), ()),
            ],
        )
        node.wait_for_log("~tree: it must be a number")
        node.wait_for_log("/serial_node/missing, which is not set")
        for name in (*["~missing"] * 20, "~absent"):  # as a loop that asks again and again
            self.request_parameter(name)
        node.wait_for_log("/serial_node/absent, which is not set")
        self.assertLess(len(node.logged("missing, which is not set")), 10)
        line = log.wait_for(lambda line: line.msg == "it is hot")
        self.assertEqual((line.name, line.level), (self.space + "/serial_node/board", Log.ERROR))
        node.wait_for_log("[ERROR]", "/serial_node/board: it is hot")

    def request_parameter(self, name: str) -> None:
        """Request a parameter until it is answered, as sketches do.

        A request that the board has not sent, or whose answer is on its way, is not repeated.
        """
        before, sent_at = len(self.sketch.parameters), [-math.inf]

        def request(device: Device) -> None:
            device.request_parameter(name)
            sent_at.append(time.monotonic())

        def is_answered() -> bool:
            if len(self.sketch.parameters) > before:
                return True
            if sent_at and time.monotonic() - sent_at[-1] > REPEAT_S:
                sent_at.clear()
                self.do(request)
            return False

        wait_until(is_answered, lambda: f"{name} is not answered")

    def test_the_board_gets_the_time_of_ros(self) -> None:
        master = Master()
        self.addCleanup(master.kill)
        environment = {"ROS_MASTER_URI": master.uri}
        rostopic = shutil.which("rostopic")
        assert rostopic is not None
        Server(master.uri).set("/use_sim_time", True)
        clock = ["pub", "-r", "20", "-s", "/clock", "rosgraph_msgs/Clock", "{clock: {secs: 77}}"]
        self.addCleanup(Process(rostopic, clock, environment).end)
        self.start(environment=environment)
        wait_until(
            lambda: self.board.device is not None and self.board.device.host_time == 77.0,
            lambda: f"its time is {self.board.device and self.board.device.host_time}",
        )

    def test_the_end_of_the_node_is_told_to_the_board(self) -> None:
        node = self.start()
        self.publisher()
        offered = rospy.ServiceProxy(self.space + "/offered", SetBool)
        offered.wait_for_service(TIMEOUT_S)
        self.assertEqual(node.interrupt(), 0)
        # By itself it would notice after 11 s.
        wait_until(lambda: not self.board.device.is_configured, lambda: "it goes on", 5.0)

    def test_a_board_of_the_old_protocol_and_one_of_another_speed_are_told_in_words(self) -> None:
        old = PROBE + b"\x7d\x00\x01\x00x" + bytes([255 - (0x7D + 1 + ord("x"))])
        self.end.plug()
        self.addCleanup(self.end.unplug)
        node = self.start_node()
        node.wait_for_log("the board sends nothing", "at 115200 baud?")
        self.feed(
            b"\x00\x80garbled", node, "the received bytes are not rosserial messages", "115200"
        )
        # Such a board only answers its own time request.
        asked = bytearray()

        def is_asked() -> bool:
            asked.extend(self.end.read())
            return OLD_REQUEST in asked

        wait_until(is_asked, lambda: f"it was asked {bytes(asked)!r}")
        self.feed(old, node, "protocol from before ROS Hydro (version byte 0xff")

    def feed(self, data: bytes, node: Process, *words: str) -> None:
        """Send bytes again and again, until the node says something."""

        def is_said() -> bool:
            self.end.write(data)
            return bool(node.logged(*words))

        wait_until(is_said, lambda: f"{words} not in {node.logged()}")


if __name__ == "__main__":
    rospy.init_node("test_any_sketch")
    rosrun("serial_link", "any_sketch", AnySketch)
