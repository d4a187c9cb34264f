"""DC motor node: its input is a voltage, its output a speed."""

from typing import Optional

import rospy
from std_msgs.msg import Float32, String

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from motor_control.enable_sequence import DISABLED, ENABLED, WAITING
from motor_control.motor_parameters import MotorParameters
from motor_control_msgs.srv import SetProcessBool, SetProcessBoolRequest, SetProcessBoolResponse
from nodekit import Node, run


class DcMotor:
    """Publishes the speed y of a motor, tau dy/dt + y = K u, while it is enabled.

    When enabled, it starts from its initial conditions, with an input of 0 until the first message.
    When disabled, it stops: it publishes a final speed of 0, and then nothing.

    :ROS Subscribers:
        - ``motor_input_u`` (std_msgs/Float32); a value that is not finite is ignored, with a
            warning

    :ROS Publishers:
        - ``motor_speed_y`` (std_msgs/Float32)
        - ``motor_state`` (std_msgs/String), latched: ``waiting``, ``enabled`` or ``disabled``

    :ROS Services:
        - ``EnableProcess`` (motor_control_msgs/SetProcessBool): start or stop the motor

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.MotorParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(MotorParameters)
        self._settings = self._parameters.values
        self._input = 0.0
        # None while stopped; its time starts with the first step, at _begun_at.
        self._plant: Optional[FirstOrderPlant] = None
        self._begun_at: Optional[float] = None
        self._speed_publisher = node.create_publisher("motor_speed_y", Float32)
        self._state_publisher = node.create_publisher("motor_state", String, latch=True)
        self._service_name = node.resolve("EnableProcess")
        node.create_subscription("motor_input_u", Float32, self._on_input, finite=True)
        node.create_service("EnableProcess", SetProcessBool, self._enable)
        node.create_timer(lambda: 1.0 / self._parameters.values.sample_time, self._step)
        self._state = ""
        self._publish_state(WAITING)

    def _on_input(self, message: Float32) -> None:
        self._input = message.data

    def _step(self, elapsed: float) -> None:
        if self._plant is None:
            return
        if self._begun_at is None:
            self._begun_at = elapsed
        moment = elapsed - self._begun_at
        self._apply_settings(self._plant, moment)
        self._plant.hold(moment, self._input)
        self._speed_publisher.publish(Float32(self._plant.output(moment)))

    def _apply_settings(self, plant: FirstOrderPlant, moment: float) -> None:
        new, old = self._parameters.values, self._settings
        if new is old:
            return
        plant.change(moment, new.plant)
        if new.initial_conditions != old.initial_conditions:
            plant.set_output(moment, new.initial_conditions)
        self._settings = new

    def _enable(self, request: SetProcessBoolRequest) -> SetProcessBoolResponse:
        if rospy.is_shutdown():
            return SetProcessBoolResponse(False, "the motor is shutting down")
        state = ENABLED if request.enable else DISABLED
        if request.enable == (self._plant is not None):
            self._publish_state(state)  # waiting becomes disabled
            return SetProcessBoolResponse(True, state + " already")
        if request.enable:
            self._start()
        else:
            self._stop()
        self._publish_state(state)
        rospy.loginfo("%s: %s", self._service_name, state)
        return SetProcessBoolResponse(True, state)

    def _publish_state(self, state: str) -> None:
        if state != self._state:
            self._state = state
            self._state_publisher.publish(state)

    def _start(self) -> None:
        self._settings = self._parameters.values
        self._plant = FirstOrderPlant(self._settings.plant, self._settings.initial_conditions)
        self._begun_at = None
        self._input = 0.0

    def _stop(self) -> None:
        self._plant = None
        self._speed_publisher.publish(Float32(0.0))


def main() -> None:
    """Run the node until it is shut down."""
    run("dc_motor", DcMotor)
