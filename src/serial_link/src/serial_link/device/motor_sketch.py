"""Sketch of the simulated board: a motor, a button, a potentiometer and a lamp."""

import math
import struct
from typing import Optional

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.device.rosserial_device import Device, Endpoint
from serial_link.device.motor import PWM_STEPS, Motor
from serial_link.negotiation.payloads import (
    INFO,
    PUBLISHER,
    SERVICE_SERVER,
    SUBSCRIBER,
    ParameterValues,
)

#: The motor is stopped after this long without input [s]: the host may be gone.
INPUT_TIMEOUT_S = 0.5
#: Interval for repeating the button's state [s], for late subscribers.
BUTTON_EVERY_S = 1.0
#: Interval for reading the potentiometer [s], and its full scale (10 bits).
POTENTIOMETER_EVERY_S, FULL_SCALE = 0.1, 1023
NOT_TURNING, TURNING, MAX_SPEED = "Motor Not Turning", "Motor Turning", "Motor Max Speed"

_INPUT, _OUTPUT = struct.Struct("<fd"), struct.Struct("<fdI")

#: The md5sums are those in the headers of these messages.
TOPICS = (
    Endpoint(
        PUBLISHER, "motor_output", "pid_control/motor_output", "6f371a723b35f6884908910ed6144b2d"
    ),
    Endpoint(PUBLISHER, "button", "std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a"),
    Endpoint(PUBLISHER, "potentiometer", "std_msgs/UInt16", "1df79edf208b629fe6b81923a544552d"),
    Endpoint(
        SUBSCRIBER, "motor_input", "pid_control/motor_input", "68938b46224a92992b7cd8fd6233cc91"
    ),
    Endpoint(SUBSCRIBER, "led", "std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a"),
    Endpoint(
        SERVICE_SERVER,
        "zero_encoder",
        "std_srvs/Trigger",
        "d41d8cd98f00b204e9800998ecf8427e",
        "937c9679a518e3a18d831e57125ea522",
    ),
)


class BoardControls:
    """Button and potentiometer of the board, and settings of its motor.

    :param plant: settings of the connected motor

    :ivar button: whether it is pressed
    :ivar potentiometer: position, from 0 to 1
    :ivar plant: as given; may be replaced
    """

    def __init__(self, plant: PlantSettings) -> None:
        self.plant = plant
        self.button = False
        self.potentiometer = 0.5


class MotorSketch:
    """Sketch that publishes the motor's speed and the values of the controls, and drives the motor.

    Times in messages have 32-bit precision, as on an 8-bit Arduino.

    :param motor: the motor, which keeps turning while the board resets
    :param controls: button and potentiometer
    :param rate: publishing rate of the speed [Hz]
    :param began_at: start time of the board [s]
    :param floods: whether the speed is published as fast as the line allows
    """

    topics = TOPICS

    def __init__(
        self,
        motor: Motor,
        controls: BoardControls,
        rate: float,
        began_at: float,
        floods: bool = False,
    ) -> None:
        self.is_lit = False
        self._motor, self._controls, self._plant = motor, controls, controls.plant
        self._period, self._floods = 1.0 / rate, floods
        self._began_at = self._next_at = self._measured_at = self._turn_at = began_at
        self._counts = motor.counts(began_at)
        self._driven_at = -math.inf
        self._button: Optional[bool] = None
        self._button_due_at = began_at
        motor.drive(began_at, 0.0)

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        """Drive the motor, switch the lamp, or answer the service."""
        if name == "motor_input" and len(payload) == _INPUT.size:
            share = _INPUT.unpack(payload)[0]
            if math.isfinite(share):
                self._driven_at = now
                self._motor.drive(now, share)
        elif name == "led" and payload:
            self.is_lit = bool(payload[0])
            device.log(INFO, f"led {'on' if self.is_lit else 'off'}")
        elif name == "zero_encoder":
            counts = self._motor.counts(now)
            self._motor.zero(now)
            self._counts -= counts
            text = f"{counts} counts before".encode()
            device.publish(name, struct.pack("<BI", 1, len(text)) + text)

    def on_parameter(self, device: Device, now: float, values: ParameterValues) -> None:
        """Ignore parameters: this sketch requests none."""

    def loop(self, device: Device, now: float) -> None:
        """Publish the values whose time has come."""
        if self._controls.plant is not self._plant:
            self._plant = self._controls.plant
            self._motor.change(now, self._plant)
        if now - self._driven_at > INPUT_TIMEOUT_S and self._motor.pwm:
            self._motor.drive(now, 0.0)
        if device.is_configured and (
            self._controls.button != self._button or now >= self._button_due_at
        ):
            self._button, self._button_due_at = self._controls.button, now + BUTTON_EVERY_S
            device.publish("button", bytes((self._button,)))
        if now >= self._turn_at:
            self._turn_at = max(self._turn_at + POTENTIOMETER_EVERY_S, now - POTENTIOMETER_EVERY_S)
            value = round(self._controls.potentiometer * FULL_SCALE)
            device.publish("potentiometer", struct.pack("<H", value))
        if now >= self._next_at or self._floods:
            self._next_at = max(self._next_at + self._period, now - self._period)
            if now > self._measured_at:
                device.publish("motor_output", self._measure(now))

    def next_due(self, now: float) -> float:
        """Return the time of the next publication [s]."""
        if self._floods:
            return now
        return min(self._next_at, self._turn_at)

    def _measure(self, now: float) -> bytes:
        counts = self._motor.counts(now)
        speed = self._motor.speed_of(counts - self._counts, now - self._measured_at)
        is_standing = counts == self._counts
        self._counts, self._measured_at = counts, now
        status = TURNING
        if abs(self._motor.pwm) == PWM_STEPS:
            status = MAX_SPEED
        elif is_standing:
            status = NOT_TURNING
        text = status.encode()
        (time,) = struct.unpack("<f", struct.pack("<f", now - self._began_at))
        return _OUTPUT.pack(speed, time, len(text)) + text
