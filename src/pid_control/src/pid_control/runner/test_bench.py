"""The graph that a controller finds: a motor, a set point and a clock, all in one node."""

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
    """Somebody else publishes what the judge publishes; the text says who."""


class TestBench:
    """Publishes ``motor_output``, ``set_point`` and ``/clock``, and hears ``motor_input``.

    To be made once in a process, whose ROS_MASTER_URI names the master.
    """

    def __init__(self) -> None:
        self.node = init_node(NAME)
        self._lock = threading.Lock()
        self._heard: List[float] = []
        self._clock = self.node.create_publisher("/clock", Clock)
        self._output = self.node.create_publisher("/motor_output", motor_output)
        self._set_point = self.node.create_publisher("/set_point", set_point)
        self._input = self.node.create_subscription("/motor_input", motor_input, self._hear)
        self.node.start()

    def close(self) -> None:
        """Leave the graph, while the master is there; this process does not come back to it."""
        rospy.signal_shutdown("all is judged")

    def is_connected(self) -> bool:
        """Tell whether anybody is connected."""
        return any(connections > 0 for connections in self._connections().values())

    def missing(self) -> List[str]:
        """Return the topics that nobody is connected to."""
        return [name for name, count in self._connections().items() if count == 0]

    def has_clock_listener(self) -> bool:
        """Tell whether anybody hears the clock."""
        return self._clock.get_num_connections() > 0

    def hint(self) -> str:
        """Return what is published instead of motor_input, if anything."""
        own = {"/motor_output", "/set_point", "/clock", "/rosout", "/rosout_agg"}
        types = {topic: kind for topic, kind in rospy.get_published_topics() if topic not in own}
        kind = types.get("/motor_input", motor_input._type)
        if kind != motor_input._type:
            return f"it publishes that as {kind}, not as {motor_input._type}"
        others = ", ".join(sorted(types))
        return f"it publishes {others}" if others else ""

    def check_rivals(self) -> None:
        """Make sure that nobody else is a motor or a set point.

        :raises PublisherConflict: if somebody is
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
        """Send what is due, the clock last.

        :param outgoing: what the motor and the set point say
        :param time: what the clock says, s
        """
        if outgoing.set_point is not None:
            self._set_point.publish(set_point(outgoing.set_point, time))
        if outgoing.output is not None:
            self._output.publish(motor_output(*outgoing.output))
        self._clock.publish(Clock(rospy.Time.from_sec(time)))

    def heard(self) -> List[float]:
        """Return the inputs that have come since this was asked last, oldest first."""
        with self._lock:
            heard, self._heard = self._heard, []
        return heard

    def _hear(self, message: motor_input) -> None:
        with self._lock:
            self._heard.append(message.input)
