"""Test bench of a controller: motor, set point and clock in one node."""

import threading
from typing import Dict, List

import rospy
from rosgraph_msgs.msg import Clock

from nodekit import init_node
from pid_control.judging.experiment import Outgoing
from pid_control.msg import motor_input, motor_output, set_point

#: Name of the node.
NAME = "judge"


class PublisherConflict(Exception):
    """Another node publishes a topic of the bench; the message names it."""


class TestBench:
    """Node that publishes ``motor_output``, ``set_point`` and ``/clock``, and receives the inputs.

    Create it once per process, after ROS_MASTER_URI is set.
    """

    def __init__(self) -> None:
        self.node = init_node(NAME)
        self._lock = threading.Lock()
        self._inputs: List[float] = []
        self._clock = self.node.create_publisher("/clock", Clock)
        self._output = self.node.create_publisher("/motor_output", motor_output)
        self._set_point = self.node.create_publisher("/set_point", set_point)
        self._input = self.node.create_subscription("/motor_input", motor_input, self._on_input)
        self.node.start()

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
        """Return a text about topics published instead of motor_input, if any."""
        own = {"/motor_output", "/set_point", "/clock", "/rosout", "/rosout_agg"}
        types = {topic: kind for topic, kind in rospy.get_published_topics() if topic not in own}
        kind = types.get("/motor_input", motor_input._type)
        if kind != motor_input._type:
            return f"it publishes that as {kind}, not as {motor_input._type}"
        others = ", ".join(sorted(types))
        return f"it publishes {others}" if others else ""

    def check_publishers(self) -> None:
        """Check that no other node publishes the bench's topics.

        :raises PublisherConflict: if another node does
        """
        for topic, nodes in rospy.get_master().getSystemState()[2][0]:
            others = [node for node in nodes if node != rospy.get_name()]
            if topic in ("/motor_output", "/set_point") and others:
                who = " and ".join(others)
                raise PublisherConflict(
                    f"{who} publishes {topic[1:]}, which the judge does: leave that out"
                )

    def _connections(self) -> Dict[str, int]:
        topics = {"motor_output": self._output, "set_point": self._set_point}
        counts = {name: topic.get_num_connections() for name, topic in topics.items()}
        return {**counts, "motor_input": self._input.get_num_connections()}

    def send(self, outgoing: Outgoing, time: float) -> None:
        """Publish the messages that are due, the clock last.

        :param outgoing: messages of the motor and the set point
        :param time: time of the clock [s]
        """
        if outgoing.set_point is not None:
            self._set_point.publish(set_point(outgoing.set_point, time))
        if outgoing.output is not None:
            self._output.publish(motor_output(*outgoing.output))
        self._clock.publish(Clock(rospy.Time.from_sec(time)))

    def pop_inputs(self) -> List[float]:
        """Return the inputs received since the previous call, oldest first."""
        with self._lock:
            inputs, self._inputs = self._inputs, []
        return inputs

    def _on_input(self, message: motor_input) -> None:
        with self._lock:
            self._inputs.append(message.input)
