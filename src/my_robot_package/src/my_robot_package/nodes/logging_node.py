"""Log lines of each level, and a node's report of itself."""

from typing import List

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from nodekit import IntParameter, Node, ParameterSet, SingleThreadedExecutor, run
from nodekit.master import MasterClient


class LoggingNodeParameters(ParameterSet):
    """Parameters of logging_node."""

    robot_id = IntParameter(42, minimum=0, help="number of the robot")


class LoggingNode:
    """Logs at startup a line of each level, one with a number, and one about an exception.

    The debug line is below the node's level, info, so it is not shown. ``rosservice call
    NODE/set_logger_level rosout debug`` changes the level of a running node for its later lines.

    :ROS Services:
        - ``~debug_node_info`` (std_srvs/Trigger): logs and returns the node's name and the topics
            and services on the graph

    :ROS Parameters:
        - private, can be changed at run time: see :class:`LoggingNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._parameters = node.declare_parameters(LoggingNodeParameters)
        # In its own thread, because the master may be slow to answer.
        SingleThreadedExecutor().add_node(node)
        node.create_service("~debug_node_info", Trigger, self.debug_node_info)
        self._log()

    def _log(self) -> None:
        rospy.logdebug("Debug message")
        rospy.loginfo("Info message")
        rospy.logwarn("Warning message")
        rospy.logerr("Error message")
        rospy.logfatal("Fatal message")
        rospy.loginfo("Robot %d initialized", self._parameters.values.robot_id)
        try:
            10 / 0
        except ZeroDivisionError as error:
            rospy.logerr("Division error: %s", error)

    def debug_node_info(self, request: TriggerRequest) -> TriggerResponse:
        """Log the node's name, and the topics and services on the graph."""
        namespace, _, name = self._node.name.rpartition("/")
        # Unlike rosgraph.Master it has a timeout, after which the caller gets an error.
        with MasterClient(self._node.name) as master:
            state = master.system_state()
        topics = sorted({topic for kind in state[:2] for topic, _ in kind})
        services = sorted(service for service, _ in state[2])
        lines: List[str] = [
            f"Node: {name}, Namespace: {namespace or '/'}",
            f"Topics: {', '.join(topics)}",
            f"Services: {', '.join(services)}",
        ]
        for line in lines:
            rospy.loginfo("%s", line)
        return TriggerResponse(True, "\n".join(lines))


def main() -> None:
    """Run the node until it is shut down."""
    run("logging_node", LoggingNode)
