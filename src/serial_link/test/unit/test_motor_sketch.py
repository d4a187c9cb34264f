"""The sketch of the simulated board."""

import struct
from typing import Any, List

import pytest
from pid_control.msg import motor_input, motor_output
from std_msgs.msg import Bool, UInt16
from std_srvs.srv import Trigger, TriggerResponse

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.device.rosserial_device import Device
from serial_link.device.motor import Motor
from serial_link.device.motor_sketch import (
    FULL_SCALE,
    INPUT_TIMEOUT_S,
    TOPICS,
    BoardControls,
    MotorSketch,
)
from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import encode
from serial_link.negotiation.payloads import INFO, decode_log

CLASSES = {
    "pid_control/motor_output": motor_output,
    "pid_control/motor_input": motor_input,
    "std_msgs/Bool": Bool,
    "std_msgs/UInt16": UInt16,
}
OUTPUT, BUTTON, POTENTIOMETER, ZERO = range(125, 129)
INPUT, LED, ZERO_REQUEST = range(100, 103)


class Bench:
    """A sketch on a device that was asked for its topics, at 100 s."""

    def __init__(self, floods: bool = False, rate: float = 100.0) -> None:
        plant = PlantSettings(13.1, 0.04, 13.0, 0.05)
        self.motor, self.controls = Motor(plant, 1320, 100.0), BoardControls(plant)
        self.sketch = MotorSketch(self.motor, self.controls, rate, 100.0, floods)
        self.device = Device(self.sketch)
        self.device.receive(100.0, encode(0, b""))
        self.device.output()

    def run(self, start: float, seconds: float) -> List[Any]:
        """Run it in steps of 1 ms, and return the frames."""
        for step in range(round(1000 * seconds)):
            self.device.loop(start + 0.001 * step)
        return Decoder().feed(self.device.output())

    def drive(self, now: float, share: float) -> None:
        self.device.receive(now, encode(INPUT, struct.pack("<fd", share, 0.0)))


def outputs(frames: List[Any]) -> List[Any]:
    return [motor_output().deserialize(payload) for topic, payload in frames if topic == OUTPUT]


def test_its_md5sums_are_those_of_the_messages() -> None:
    assert TOPICS
    for endpoint in TOPICS:
        if endpoint.type == "std_srvs/Trigger":
            assert endpoint.md5sum == Trigger._request_class._md5sum
            assert endpoint.answer_md5sum == Trigger._response_class._md5sum
        else:
            assert endpoint.md5sum == CLASSES[endpoint.type]._md5sum


def test_speed_is_published_at_rate_with_board_time() -> None:
    bench = Bench()
    bench.drive(100.0, 0.5)
    heard = outputs(bench.run(100.001, 0.4))
    assert 39 <= len(heard) <= 41
    quantum = bench.motor.speed_of(1, 0.01)
    assert heard[-1].output == pytest.approx(13.1 * 128 / 255, abs=quantum)
    assert heard[-1].output / quantum == pytest.approx(round(heard[-1].output / quantum), abs=1e-3)
    assert heard[-1].time == pytest.approx(0.4, abs=0.011)
    assert heard[-1].status == "Motor Turning"


def test_status_describes_motor() -> None:
    bench = Bench()
    assert outputs(bench.run(100.001, 0.05))[-1].status == "Motor Not Turning"
    bench.drive(100.05, 1.0)
    assert outputs(bench.run(100.051, 0.3))[-1].status == "Motor Max Speed"
    bench.drive(100.4, -1.0)
    assert outputs(bench.run(100.401, 0.05))[-1].status == "Motor Max Speed"


def test_rate_does_not_depend_on_the_duration_of_the_loop() -> None:
    bench = Bench()
    for step in range(100):
        bench.device.loop(100.0 + 0.007 * step)
    assert 68 <= len(outputs(Decoder().feed(bench.device.output()))) <= 71


def test_slow_output_does_not_slow_the_potentiometer_down() -> None:
    bench = Bench(rate=0.1)
    bench.device.loop(100.0)
    assert bench.sketch.next_due(100.0) == pytest.approx(100.1)


def test_sketch_that_is_started_again_stops_the_motor_and_measures_from_there() -> None:
    bench = Bench()
    bench.drive(100.0, 1.0)
    assert bench.motor.counts(101.0) > 1000
    sketch = MotorSketch(bench.motor, bench.controls, 100.0, 101.0)
    assert bench.motor.pwm == 0
    bench.device = Device(sketch)
    bench.device.receive(101.0, encode(0, b""))
    bench.device.output()
    speeds = [output.output for output in outputs(bench.run(101.001, 0.05))]
    assert 0.0 < speeds[0] < 20.0


def test_replaced_motor_is_used() -> None:
    bench = Bench()
    bench.controls.plant = bench.controls.plant._replace(gain=6.0)
    bench.drive(100.0, 0.5)
    quantum = bench.motor.speed_of(1, 0.01)
    speed = outputs(bench.run(100.001, 0.4))[-1].output
    assert speed == pytest.approx(6.0 * 128 / 255, abs=quantum)


def test_motor_stops_when_nobody_drives_it() -> None:
    bench = Bench()
    bench.drive(100.0, 0.5)
    bench.run(100.001, INPUT_TIMEOUT_S - 0.1)
    assert bench.motor.pwm == 128
    bench.run(100.401, 0.2)
    assert bench.motor.pwm == 0


@pytest.mark.parametrize("payload", [b"", bytes(11), struct.pack("<fd", float("nan"), 0.0)])
def test_invalid_input_does_not_move_motor(payload: bytes) -> None:
    bench = Bench()
    bench.drive(100.0, 0.5)
    bench.device.receive(100.1, encode(INPUT, payload))
    assert bench.motor.pwm == 128


def test_button_is_published_on_change_and_potentiometer_periodically() -> None:
    bench = Bench()
    frames = bench.run(100.001, 0.3)
    assert [payload for topic, payload in frames if topic == BUTTON] == [b"\0"]
    frames = Bench().run(100.001, 2.2)
    assert [payload for topic, payload in frames if topic == BUTTON] == [b"\0"] * 3
    bench.controls.button, bench.controls.potentiometer = True, 1.0
    frames = bench.run(100.301, 0.3)
    assert [payload for topic, payload in frames if topic == BUTTON] == [b"\1"]
    turned = [
        UInt16().deserialize(payload).data for topic, payload in frames if topic == POTENTIOMETER
    ]
    assert turned == [FULL_SCALE] * 3


def test_lamp_and_encoder() -> None:
    bench = Bench()
    assert not bench.sketch.is_lit
    for data, is_lit in ((b"\1", True), (b"\0", False)):
        bench.device.receive(100.0, encode(LED, data))
        assert bench.sketch.is_lit is is_lit
    logged = [decode_log(payload) for topic, payload in Decoder().feed(bench.device.output())]
    assert logged == [(INFO, "led on"), (INFO, "led off")]
    bench.drive(100.0, 1.0)
    counts = bench.motor.counts(101.0)
    bench.device.receive(101.0, encode(ZERO_REQUEST, b""))
    ((topic, payload),) = Decoder().feed(bench.device.output())
    assert topic == ZERO
    answer = TriggerResponse().deserialize(payload)
    assert answer.success and answer.message == f"{counts} counts before"
    assert bench.motor.counts(101.0) == 0


def test_speed_does_not_jump_when_the_encoder_is_set_to_zero() -> None:
    bench = Bench()
    bench.drive(100.0, 1.0)
    bench.run(100.001, 0.3)
    bench.device.receive(100.3, encode(ZERO_REQUEST, b""))
    speeds = [output.output for output in outputs(bench.run(100.301, 0.05))]
    assert speeds == pytest.approx(5 * [13.0], abs=bench.motor.speed_of(2, 0.01))


def test_floods_on_request() -> None:
    bench = Bench(floods=True)
    assert len(outputs(bench.run(100.001, 0.1))) >= 99
    assert bench.sketch.next_due(100.1) == 100.1
    assert Bench().sketch.next_due(100.0) == 100.0


def test_values_that_were_due_while_the_sketch_hung_are_not_sent_later() -> None:
    bench = Bench()
    bench.run(100.001, 0.1)
    frames = bench.run(110.0, 0.1)  # after ten seconds
    assert 10 <= len(outputs(frames)) <= 12
    assert len([1 for topic, _ in frames if topic == POTENTIOMETER]) <= 3
