#!/usr/bin/env python3
"""Boards that are restarted, also with another sketch."""

from typing import Any, List
from xmlrpc.client import ServerProxy

import rospy
from board_rig import BUFFER, BoardRig, declared
from std_msgs.msg import String
from std_srvs.srv import SetBool

from nodekit.master import MasterClient
from nodekit.testing.hearing import Ear
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until
from serial_link.endpoints.types import encode
from serial_link.negotiation.payloads import SUBSCRIBER


class NewSketch(BoardRig):
    """Boards that begin anew."""

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

    def test_what_a_new_sketch_has_no_more_is_told_and_taken_off_the_graph(self) -> None:
        said = Ear(self.space + "/said", String)
        node = self.start()
        wait_until(said.publishers, lambda: "nobody publishes")
        self.sketch.topics = self.sketch.topics[1:]
        self.board.reset()
        node.wait_for_log("the board no longer publishes said")
        wait_until(lambda: not said.publishers(), lambda: "it still publishes")
        self.assertEqual(len(node.logged("the board no longer")), 1)

    def test_what_is_latched_is_too_long_for_the_smaller_buffer_of_a_new_sketch(self) -> None:
        node = self.start()
        text = "x" * (BUFFER - 4)
        self.publisher(latch=True).publish(text)
        self.wait_until_told(text)
        self.buffer = 70
        self.board.reset()
        node.wait_for_log("/told: a message of 100 bytes is not sent", "the board's buffer has 70")

    def test_a_restarted_board_gets_what_is_latched_by_publishers_that_live(self) -> None:
        self.sketch.topics = (*self.sketch.topics, declared(SUBSCRIBER, "last", String))
        self.start()
        living = rospy.Publisher(self.space + "/last", String, queue_size=1, latch=True)
        self.addCleanup(living.unregister)
        living.publish("still here")
        gone = self.publisher(latch=True)
        gone.publish("gone")
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
