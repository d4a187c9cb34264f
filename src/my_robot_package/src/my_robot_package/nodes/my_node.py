"""A node with a timer, a publisher and a subscription."""

import rospy
from std_msgs.msg import String

from my_robot_package.robot_parameters import RobotParameters
from nodekit import Node, run


class MyRobotNode:
    """Publishes a greeting every 0.5 s, and logs received messages.

    :ROS Publishers:
        - ``topic_name`` (std_msgs/String): "Hello from" and the node's name

    :ROS Subscribers:
        - ``input_topic`` (std_msgs/String)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.RobotParameters`
    """

    def __init__(self, node: Node) -> None:
        node.declare_parameters(RobotParameters)
        self._text = "Hello from " + node.name.rpartition("/")[2]
        self._publisher = node.create_publisher("topic_name", String)
        node.create_subscription("input_topic", String, self.listener_callback)
        node.create_timer(2.0, self.timer_callback)
        rospy.loginfo("MyRobotNode initialized")

    def timer_callback(self, elapsed: float) -> None:
        """Publish the greeting."""
        self._publisher.publish(self._text)

    def listener_callback(self, message: String) -> None:
        """Log the message."""
        rospy.loginfo("I heard: %s", message.data)


def main() -> None:
    """Run the node until it is shut down."""
    run("my_robot_node", MyRobotNode)
