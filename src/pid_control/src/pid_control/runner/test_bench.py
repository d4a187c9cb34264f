"""Test bench of a controller: motor, set point and clock in one node."""

import contextlib
import logging
import threading
import xmlrpc.client
from typing import Any, Dict, List, Optional, Tuple

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock

from nodekit import init_node
from pid_control.judging.experiment import OutgoingMessages
from pid_control.programs.node_queries import ask_topics
from pid_control.runner.loop_messages import LoopMessage, course_messages

#: Name of the node.
NAME = "judge"


class PublisherConflict(Exception):
    """Error of another node that publishes a topic of the bench; the text names the node."""


def ask_types(uris: Dict[str, str]) -> Tuple[Dict[str, str], List[str]]:
    """Ask nodes for the types of their topics.

    :param uris: XML-RPC URI of each node
    :returns: type of each topic, and the nodes that do not answer as a node would; a node that has
        ended is not one of these
    """
    found: Dict[str, str] = {}
    silent: List[str] = []
    for node, uri in sorted(uris.items()):
        try:
            topics = ask_topics(NAME, uri)
            found.update({**topics.published, **topics.subscribed})
        except ConnectionRefusedError:
            continue
        except Exception:  # of any type: a student's node may reply anything
            silent.append(node)
    return found, silent


class TestBench:
    """Node that publishes ``motor_output``, ``set_point`` and ``/clock``, and receives the inputs.

    Create it once per process, after ROS_MASTER_URI is set.

    :param messages: messages of the topics; the course's by default

    :ivar messages: messages of the topics
    """

    def __init__(self, messages: Optional[Dict[str, LoopMessage]] = None) -> None:
        self.node = init_node(NAME)
        # The report names other types, and a controller that ends.
        logging.getLogger("rosout").setLevel(logging.ERROR)
        self.messages = messages or course_messages()
        self._lock = threading.Lock()
        self._inputs: List[float] = []
        self._clock = self.node.create_publisher("/clock", Clock)
        self._open()
        self.node.start()

    def _open(self) -> None:
        classes = {topic: one.message_class for topic, one in self.messages.items()}
        self._output = self.node.create_publisher("/motor_output", classes["motor_output"])
        self._set_point = self.node.create_publisher("/set_point", classes["set_point"])
        self._input = self.node.create_subscription(
            "/motor_input", classes["motor_input"], self._on_input
        )

    def follow(self, messages: Dict[str, LoopMessage]) -> None:
        """Use other messages for the topics from now on.

        :param messages: message of each topic
        """
        self._output.close()
        self._set_point.close()
        self._input.close()
        self.messages = messages
        self._open()

    def types_of_controller(self) -> Dict[str, str]:
        """Return the types of other nodes' topics, from the nodes themselves."""
        return self._types()[0]

    def _types(self) -> Tuple[Dict[str, str], List[str]]:
        publishers, subscribers, _ = rospy.get_master().getSystemState()[2]
        nodes = {node for _, names in publishers + subscribers for node in names}
        uris: Dict[str, str] = {}
        for node in nodes - {rospy.get_name()}:
            with contextlib.suppress(OSError, rosgraph.MasterException, xmlrpc.client.Error):
                uris[node] = rosgraph.Master(NAME).lookupNode(node)
        return ask_types(uris)

    def close(self) -> None:
        """Shut the node down for good, while the master still runs."""
        rospy.signal_shutdown("the judgement is complete")

    def is_connected(self) -> bool:
        """Return True if any topic has a connection."""
        return any(connections > 0 for connections in self._connections().values())

    def missing(self) -> List[str]:
        """Return the topics without a connection."""
        return [name for name, count in self._connections().items() if count == 0]

    def has_clock_listener(self) -> bool:
        """Return True if the clock has a subscriber."""
        return self._clock.get_num_connections() > 0

    def hint(self) -> str:
        """Return a text about other types, or topics, of the controller, if any."""
        own = {"/motor_output", "/set_point", "/motor_input", "/clock", "/rosout", "/rosout_agg"}
        types, silent = self._types()
        for name in self.missing():
            message_class = self.messages[name].message_class
            msg_type = types.get("/" + name, message_class._type)
            if msg_type != message_class._type:
                return f"its {name} is {msg_type}, not {message_class._type}"
            if "/" + name in types:
                return f"its {name} has another definition of {msg_type} than the judge"
        others = ", ".join(sorted(topic for topic in types if topic not in own))
        if not others and silent:
            return f"its types are unknown: {', '.join(silent)} does not answer"
        return f"it has the topics {others}" if others else ""

    def check_publishers(self) -> None:
        """Check that no other node publishes the bench's topics.

        :raises PublisherConflict: if another node does
        """
        for topic, nodes in rospy.get_master().getSystemState()[2][0]:
            others = [node for node in nodes if node != rospy.get_name()]
            if topic in ("/motor_output", "/set_point") and others:
                who = " and ".join(others)
                raise PublisherConflict(f"{who} publishes {topic[1:]}, like the judge; remove that")

    def _connections(self) -> Dict[str, int]:
        topics = {"motor_output": self._output, "set_point": self._set_point}
        counts = {name: topic.get_num_connections() for name, topic in topics.items()}
        return {**counts, "motor_input": self._input.get_num_connections()}

    def send(self, outgoing: OutgoingMessages, time: float) -> None:
        """Publish the messages that are due, the clock last.

        :param outgoing: messages of the motor and the set point
        :param time: time of the clock [s]
        """
        if outgoing.set_point is not None:
            message = self.messages["set_point"].filled(outgoing.set_point, time)
            self._set_point.publish(message)
        if outgoing.output is not None:
            self._output.publish(self.messages["motor_output"].filled(*outgoing.output))
        self._clock.publish(Clock(rospy.Time.from_sec(time)))

    def pop_inputs(self) -> List[float]:
        """Return the inputs received since the previous call, oldest first."""
        with self._lock:
            inputs, self._inputs = self._inputs, []
        return inputs

    def _on_input(self, message: Any) -> None:
        with self._lock:
            self._inputs.append(self.messages["motor_input"].value(message))
