#!/usr/bin/env python3
"""Boards that are restarted, possibly with another sketch."""

import threading
from typing import Any, List
from xmlrpc.client import ServerProxy

import rospy
from helpers.board_rig import BUFFER, BoardRig, TestSketch, endpoint
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool

from nodekit.master import MasterClient
from nodekit.testing.processes import free_port
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until
from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.board.transports import TcpTransport
from serial_link.device.rosserial_device import Device
from serial_link.endpoints.types import encode
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, TOPICS


class DamagedOnce(Device):
    """Announces its topics, the first time all damaged."""

    is_damaged = True

    def _send(self, topic_id: int, payload: bytes) -> None:
        super()._send(topic_id, payload)
        if self.is_damaged and topic_id in TOPICS:
            self._output[-1] ^= 1

    def receive(self, now: float, data: bytes) -> None:
        super().receive(now, data)
        self.is_damaged = self.is_damaged and not self.is_configured


class NewSketch(BoardRig):
    """Boards that are restarted."""

    def test_call_under_way_fails_when_the_board_is_restarted(self) -> None:
        self.sketch.answers = False
        node = self.start("_service_timeout:=20.0")
        offered = rospy.ServiceProxy(self.space + "/offered", SetBool)
        offered.wait_for_service(TIMEOUT_S)
        failures: List[str] = []

        def call() -> None:
            try:
                offered(True)
            except rospy.ServiceException as error:
                failures.append(str(error))

        in_thread(call)
        wait_until(lambda: self.sketch.heard, lambda: "the board was not called")
        self.board.reset()
        wait_until(lambda: failures, lambda: "the call goes on", 15.0)
        self.assertRegex(failures[0], "the board was restarted")
        node.wait_for_log("the board was restarted")

    def test_two_boards_at_one_tcp_port_have_a_namespace_each(self) -> None:
        number = free_port()
        self.port = "tcp"
        node = self.start_node(f"_tcp_port:={number}", "_tcp_boards:=left,right")
        sketches = TestSketch(), TestSketch()
        for name, sketch in zip(("left", "right"), sketches):
            make = lambda now, sketch=sketch: Device(sketch, BUFFER, 512)  # noqa: E731
            board = SimulatedBoard(TcpTransport("localhost", number), 0, make)
            board.faults = Faults(is_plugged=False)
            board.start()
            self.addCleanup(board.close)
            board.faults = Faults()
            node.wait_for_log(f"the board publishes {name}/said")
        for name, sketch in zip(("left", "right"), sketches):
            publisher = rospy.Publisher(f"{self.space}/{name}/told", String, latch=True)
            self.addCleanup(publisher.unregister)
            publisher.publish(name)
        for name, sketch in zip(("left", "right"), sketches):
            # rospy sends it twice where it is published in the moment in which the node connects.
            wait_until(lambda: {*sketch.texts()} == {name}, lambda: f"{sketch.heard}")

    def test_two_subscribers_of_one_topic_in_a_sketch_both_hear_and_wrong_names_are_told(
        self,
    ) -> None:
        told = self.sketch.topics[1]
        self.sketch.topics = [told, told, told._replace(name="my-topic")]
        # rospy sends it twice where it is published in the moment in which the node connects.
        self.publisher(latch=True).publish("once")
        node = self.start()
        wait_until(lambda: self.sketch.texts() == ["once"] * 2, lambda: f"{self.sketch.heard}")
        node.wait_for_log("my-topic is refused: 'my-topic' is not a valid ROS name: in the sketch")
        self.board.reset()
        wait_until(lambda: self.sketch.texts() == ["once"] * 4, lambda: f"{self.sketch.heard}")

    def test_what_a_new_sketch_has_no_more_is_told_and_taken_off_the_graph(self) -> None:
        said = MessageRecorder(self.space + "/said", String)
        node = self.start()
        wait_until(said.publishers, lambda: "no publisher")
        self.sketch.topics = self.sketch.topics[1:]
        self.board.reset()
        node.wait_for_log("the board no longer publishes said")
        wait_until(lambda: not said.publishers(), lambda: "it still publishes")
        self.assertEqual(len(node.logged("the board no longer")), 1)

    def test_nothing_is_heard_under_the_name_that_its_id_had_in_the_sketch_before(self) -> None:
        told, other = (endpoint(SUBSCRIBER, name, String) for name in ("told", "other"))
        self.sketch.topics = (told, other)
        node = self.start()
        publisher, is_over = self.publisher(), threading.Event()

        def stream() -> None:
            while not is_over.wait(0.005):
                publisher.publish("x")

        thread = in_thread(stream)
        self.addCleanup(thread.join, TIMEOUT_S)
        self.addCleanup(is_over.set)
        self.wait_until_told("x")
        self.board.faults = Faults(is_plugged=False)
        node.wait_for_log("is gone")
        before = self.board.device
        self.sketch.topics = (other, told)
        self.board.reset()
        wait_until(lambda: self.board.device not in (None, before), lambda: "it does not start")
        self.sketch.heard.clear()
        self.board.faults = Faults()
        wait_until(lambda: self.sketch.texts(), lambda: f"{self.sketch.heard[:3]}")
        self.assertEqual({name for name, _ in self.sketch.heard}, {"told"})

    def test_a_topic_has_the_type_that_the_new_sketch_gives_it(self) -> None:
        node = self.start()
        node.wait_for_log("the board publishes said (std_msgs/String)")
        self.sketch.topics = (endpoint(PUBLISHER, "said", Bool), *self.sketch.topics[1:])
        # Published at once, before the node knows that these are all topics.
        self.sketch.loop = self.publish  # type: ignore[assignment]
        self.board.reset()
        node.wait_for_log("the board publishes said (std_msgs/Bool)")
        MessageRecorder(self.space + "/said", Bool).wait_for(lambda heard: heard.data)
        self.assertEqual(node.logged("said is refused"), [])

    def publish(self, device: Device, now: float) -> None:
        device.publish("said", encode(Bool(True)))

    def test_what_a_damaged_announcement_leaves_out_stays_on_the_graph(self) -> None:
        said = MessageRecorder(self.space + "/said", String)
        self.publisher(latch=True).publish("latched")
        node = self.start()
        self.wait_until_told("latched")
        self.sketch.heard.clear()
        self.board._make_device = lambda now: DamagedOnce(self.sketch, BUFFER)
        self.board.reset()
        self.wait_until_told("latched")

        def is_heard() -> bool:  # this topic may be announced after the other one
            self.do(lambda device: device.publish("said", encode(String("back"))))
            return said.count() > 0

        wait_until(is_heard, lambda: "the board is not heard")
        self.assertEqual(node.logged("the board no longer"), [])

    def test_what_is_latched_is_too_long_for_the_smaller_buffer_of_a_new_sketch(self) -> None:
        node = self.start()
        text = "x" * (BUFFER - 4)
        self.publisher(latch=True).publish(text)
        self.wait_until_told(text)
        self.buffer = 70
        self.board.reset()
        node.wait_for_log("/told: a message of 100 bytes is not sent", "the board's buffer has 70")

    def test_a_restarted_board_gets_what_is_latched_by_publishers_that_live(self) -> None:
        self.sketch.topics = (*self.sketch.topics, endpoint(SUBSCRIBER, "last", String))
        living = rospy.Publisher(self.space + "/last", String, queue_size=1, latch=True)
        self.addCleanup(living.unregister)
        living.publish("still here")
        gone = self.publisher(latch=True)
        gone.publish("gone")
        self.start()
        self.wait_until_told("gone")
        gone.unregister()
        wait_until(lambda: not self.connections("/told"), lambda: "the node still hears it")
        last = ("last", encode(String("still here")))
        wait_until(lambda: last in self.sketch.heard, lambda: str(self.sketch.heard))
        self.sketch.heard.clear()
        self.board.reset()
        # It comes after what would be sent of the other topic.
        wait_until(lambda: last in self.sketch.heard, lambda: str(self.sketch.heard))
        self.assertEqual(self.sketch.heard, [last])

    def connections(self, topic: str) -> List[Any]:
        """Return the publishers of a topic that the node is connected to."""
        with MasterClient("/test") as master:
            uri = master.lookup_node(self.space + "/serial_node")
        assert uri is not None
        entries: Any = ServerProxy(uri).getBusInfo("/test")
        return [one for one in entries[2] if (one[2], one[4]) == ("i", self.space + topic)]


if __name__ == "__main__":
    rospy.init_node("test_new_sketch")
    rosrun("serial_link", "new_sketch", NewSketch)
