"""A robot with a namespace in ROS 1 and none in ROS 2."""

import struct

import both
import rospy
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Float32, String
from test_services import ADD
from test_topics import publisher1

from motor_control_msgs.srv import SetProcessBool
from my_robot_package_interfaces.srv import AddTwoInts
from nodekit.testing.waiting import wait_until


def test_namespace_of_ros1_is_the_root_of_ros2(ros: both.Both) -> None:
    with both.Bridge("_remap:=['/robot1=/']") as bridge:
        with both.Running("basic_comms", "talker.py", "__ns:=/robot1"):
            recorder = ros.hear2("/chatter", String)
            recorder.wait(2)
            recorder.end()
            events = ros.hear2("/parameter_events", ParameterEvent)
            request = [Parameter("rate", value=2.5).to_parameter_msg()]
            answer = ros.call2(SetParameters, "/talker/set_parameters", parameters=request)
            assert answer.results[0].successful, answer
            assert rospy.get_param("/robot1/talker/rate") == 2.5
            nodes = ros.node.get_node_names_and_namespaces
            wait_until(lambda: ("talker", "/") in nodes(), lambda: str(nodes()))
            wait_until(
                lambda: (
                    ("/talker", "rate")
                    in [
                        (event.node, one.name)
                        for event in events.heard
                        for one in event.changed_parameters
                    ]
                ),
                lambda: str(events.heard),
            )
            events.end()
        with both.Running("motor_control", "dc_motor.py", "__ns:=/robot1"):
            assert ros.call2(SetProcessBool, "/EnableProcess", enable=True).success
        out = publisher1(ros, "/chatter", "std_msgs/Float32")  # of no robot, and of another type
        bridge.wait_for_log("/chatter of ROS 1: ~remap gives its name in ROS 2 to another")
        out.unregister()
        assert bridge.interrupt() == 0


def test_names_of_ros2_are_in_the_namespace(ros: both.Both) -> None:
    node = Node("lidar")
    node.declare_parameter("rate", 10.0)
    out = node.create_publisher(Float32, "/range", 10)
    server = node.create_service(AddTwoInts, "/add", lambda request, answer: answer)
    ros.executor.add_node(node)
    with both.Bridge("_remap:=['/robot1=/']"):
        recorder = ros.hear1("/robot1/range", "std_msgs/Float32")
        wait_until(lambda: out.get_subscription_count(), lambda: "the bridge does not listen")
        out.publish(Float32(data=1.5))
        assert recorder.wait()[0]._buff == struct.pack("<f", 1.5)
        recorder.end()
        assert ros.call1("/robot1/add", ADD, struct.pack("<qq", 1, 2)) == struct.pack("<q", 0)
        rate = "/robot1/lidar/rate"
        wait_until(lambda: rospy.get_param(rate, None) == 10.0, lambda: "not on the server")
        rospy.set_param(rate, 5.0)
        wait_until(lambda: node.get_parameter("rate").value == 5.0, lambda: "not taken")
        node.set_parameters([Parameter("rate", value=2.0)])
        wait_until(lambda: rospy.get_param(rate) == 2.0, lambda: "its own change is not told")
        # The bridge registers nodes and mirrors parameters in steps of their own.
        wait_until(
            lambda: rospy.get_master().lookupNode("/robot1/lidar")[0] == 1,
            lambda: "the node is not registered",
        )
    ros.executor.remove_node(node)
    node.destroy_service(server)
    node.destroy_node()
