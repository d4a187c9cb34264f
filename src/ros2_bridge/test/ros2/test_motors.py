"""The course's motor in either ROS, driven from the other."""

import struct
from typing import Any, List

import both
import pytest
import rospy
from rclpy.node import Node
from std_msgs.msg import Float32
from test_topics import publisher1

from motor_control_msgs.srv import SetProcessBool
from nodekit.testing.waiting import wait_until

#: Steady state of the course's motor for an input of 1.
FIRST = [0.07, 0.1372, 0.201712, 0.2636435, 0.3230978]


class Motor(Node):
    """The course's motor in rclpy, by its formula, with a step for each input."""

    def __init__(self) -> None:
        super().__init__("motor_of_ros2")
        for name, value in (("sample_time", 0.02), ("sys_gain_K", 1.75), ("sys_tau_T", 0.5)):
            self.declare_parameter(name, value)
        self.speed, self.is_on = 0.0, False
        self.out = self.create_publisher(Float32, "motor_speed_y", 10)
        self.create_subscription(Float32, "motor_input_u", self.step, 10)
        self.create_service(SetProcessBool, "EnableMotor", self.enable)

    def enable(self, request: Any, response: Any) -> Any:
        self.is_on = request.enable
        response.success = True
        return response

    def step(self, message: Any) -> None:
        dt, gain, tau = (
            self.get_parameter(name).value for name in ("sample_time", "sys_gain_K", "sys_tau_T")
        )
        if self.is_on:
            self.speed += dt / tau * (gain * message.data - self.speed)
            self.out.publish(Float32(data=self.speed))


def test_motor_of_ros2_is_driven_from_ros1(ros: both.Both, bridge: both.Bridge) -> None:
    motor = Motor()
    ros.executor.add_node(motor)
    kind = "motor_control_msgs/SetProcessBool"
    assert ros.call1("/EnableMotor", kind, b"\1")[:1] == b"\1"
    recorder = ros.hear1("/motor_speed_y", "std_msgs/Float32")
    voltage = publisher1(ros, "/motor_input_u", "std_msgs/Float32")
    wait_until(lambda: motor.out.get_subscription_count(), lambda: "the speed is not heard")
    wait_until(lambda: voltage.get_num_connections(), lambda: "the input is not heard")
    for _ in FIRST:
        voltage.send(struct.pack("<f", 1.0))
    speeds: List[float] = [struct.unpack("<f", one._buff)[0] for one in recorder.wait(len(FIRST))]
    assert speeds == pytest.approx(FIRST, abs=1e-6)
    key = "/motor_of_ros2/sys_gain_K"
    wait_until(lambda: rospy.get_param(key, None) == 1.75, lambda: "not on the server")
    rospy.set_param(key, 3.5)
    wait_until(lambda: motor.get_parameter("sys_gain_K").value == 3.5, lambda: "not taken")
    voltage.send(struct.pack("<f", 1.0))
    (speed,) = struct.unpack("<f", recorder.wait(len(FIRST) + 1)[-1]._buff)
    assert speed == pytest.approx(FIRST[-1] + 0.04 * (3.5 - FIRST[-1]), abs=1e-6)
    recorder.end()
    voltage.unregister()
    ros.executor.remove_node(motor)
    motor.destroy_node()


def test_motor_of_ros1_is_driven_from_ros2(ros: both.Both, bridge: both.Bridge) -> None:
    with both.Running("motor_control", "dc_motor.py", "__ns:=/one", "_initial_conditions:=0.0"):
        recorder = ros.hear2("/one/motor_speed_y", Float32)
        voltage = ros.node.create_publisher(Float32, "/one/motor_input_u", 10)
        wait_until(lambda: voltage.get_subscription_count(), lambda: "the input is not heard")
        assert ros.call2(SetProcessBool, "/one/EnableProcess", enable=True).success

        def turns() -> bool:
            voltage.publish(Float32(data=1.0))
            return any(message.data > 0.5 for message in recorder.heard)

        wait_until(turns, lambda: str(recorder.heard[-3:]))
        recorder.end()
        ros.node.destroy_publisher(voltage)
