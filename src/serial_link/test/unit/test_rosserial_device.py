"""Device side of the protocol, compatible with rosserial's board library."""

from typing import Any, List, Tuple

import pytest

from serial_link.device.device_states import CONFIGURED, WAITING
from serial_link.device.rosserial_device import HOST_LOST_S, TIME_EVERY_S, Device, Endpoint
from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import PROBE, Frame, encode
from serial_link.negotiation import payloads
from serial_link.negotiation.payloads import (
    LOG,
    PARAMETER,
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    STOP,
    SUBSCRIBER,
    TIME,
    ParameterValues,
)


class Notes:
    """Sketch that records its messages."""

    topics = (
        Endpoint(PUBLISHER, "out", "std_msgs/Bool", "a" * 32),
        Endpoint(SUBSCRIBER, "in", "std_msgs/Bool", "b" * 31 + "c"),
        Endpoint(SERVICE_SERVER, "offered", "std_srvs/Trigger", "c" * 32, "d" * 32),
        Endpoint(SERVICE_CLIENT, "called", "std_srvs/Trigger", "e" * 32, "f" * 32),
    )

    def __init__(self) -> None:
        self.heard: List[Tuple[str, Any]] = []
        self.heard_at: List[float] = []

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        self.heard.append((name, payload))
        self.heard_at.append(now)

    def on_parameter(self, device: Device, now: float, values: ParameterValues) -> None:
        self.heard.append(("parameter", values))
        self.heard_at.append(now)

    def loop(self, device: Device, now: float) -> None:
        device.publish("out", b"\1")

    def next_due(self, now: float) -> float:
        return now + 100.0


def sent(device: Device) -> List[Frame]:
    return Decoder().feed(device.output())


def configured(**options: Any) -> "tuple[Device, Notes]":
    notes = Notes()
    device = Device(notes, **options)
    device.receive(0.0, encode(PUBLISHER, b""))
    device.output()
    return device, notes


def test_device_is_silent_until_topic_request() -> None:
    device = Device(Notes())
    device.loop(3.0)
    assert device.output() == b"" and device.state == WAITING


def test_device_announces_publishers_then_subscribers() -> None:
    device = Device(Notes(), input_size=200, output_size=300)
    device.receive(0.0, encode(PUBLISHER, b""))
    first, *told = sent(device)
    assert first == (TIME, payloads.encode_time(0, 0))
    found = [(info_id, payloads.decode_topic(payload)) for info_id, payload in told]
    assert [
        (info_id, info.topic_id, info.name, info.md5sum[0], info.buffer_size)
        for info_id, info in found
    ] == [
        (0, 125, "out", "a", 300),
        (2, 126, "offered", "d", 300),
        (4, 127, "called", "e", 300),
        (1, 100, "in", "b", 200),
        (3, 101, "offered", "c", 200),
        (5, 102, "called", "f", 200),
    ]
    assert device.is_configured


def test_messages_go_both_ways_under_their_ids() -> None:
    device, notes = configured()
    device.receive(
        1.0, encode(100, b"x") + encode(101, b"y") + encode(102, b"z") + encode(103, b"")
    )
    assert notes.heard == [("in", b"x"), ("offered", b"y"), ("called", b"z")]
    for name in ("out", "offered", "called"):
        device.publish(name, name.encode())
    assert sent(device) == [(125, b"out"), (126, b"offered"), (127, b"called")]
    device.receive(
        2.0, encode(PARAMETER, payloads.encode_values(ParameterValues([1], [1.0], ["a"])))
    )
    assert notes.heard_at == [1.0, 1.0, 1.0, 2.0]
    assert notes.heard[-1] == ("parameter", ((1,), (1.0,), ("a",)))
    device.request_parameter("~gain")
    assert sent(device) == [(PARAMETER, payloads.encode_name("~gain"))]


def test_only_a_board_that_waits_answers_a_probe() -> None:
    device = Device(Notes())
    for number in (1, 2, 1):
        device.receive(0.0, number * PROBE)
        assert sent(device) == number * [(TIME, payloads.encode_time(0, 0))]
    device, _ = configured()
    device.receive(0.0, PROBE)
    assert sent(device) == []


def test_time_is_asked_for_and_without_an_answer_the_host_is_forgotten() -> None:
    assert (TIME_EVERY_S, HOST_LOST_S) == (2.5, 11.0)  # as in rosserial's node_handle.h
    device, _ = configured()
    device.loop(TIME_EVERY_S)
    assert [frame.topic_id for frame in sent(device)] == [TIME, 125]
    device.loop(TIME_EVERY_S + 0.1)
    assert [frame.topic_id for frame in sent(device)] == [125]
    device.receive(3.0, encode(TIME, payloads.encode_time(7, 500_000_000)))
    assert device.host_time == 7.5
    device.loop(2.9 + HOST_LOST_S)
    assert device.state == CONFIGURED
    device.loop(3.0 + HOST_LOST_S)
    assert device.state == WAITING
    assert 14.0 < device.next_due(14.0) <= 14.0 + TIME_EVERY_S
    assert Device(Notes()).next_due(14.0) > 14.0  # a board that waits for its host is idle


def test_topic_request_after_a_long_silence_is_from_a_present_host() -> None:
    device = Device(Notes())
    device.receive(20.0, encode(PUBLISHER, b""))
    device.loop(20.1)
    assert device.is_configured


def test_stop_ends_publishing_until_topic_request() -> None:
    device, _ = configured()
    device.receive(1.0, encode(STOP, b""))
    device.publish("out", b"")
    assert device.output() == b"" and device.state == WAITING


def test_too_large_message_is_dropped_and_logged() -> None:
    device, _ = configured(output_size=100)
    device.publish("out", bytes(92))
    assert sent(device) == [(125, bytes(92))]
    device.publish("out", bytes(93))
    ((topic_id, payload),) = sent(device)
    assert topic_id == LOG and payloads.decode_log(payload)[0] == payloads.ERROR
    device.log(payloads.INFO, 100 * "x")
    assert sent(device) == []


@pytest.mark.parametrize("name", ["out", "in", "offered"])
def test_wrong_md5sum_is_announced_for_one_topic(name: str) -> None:
    told = []
    for wrong in ("", name):
        device = Device(Notes(), wrong_md5=wrong)
        device.receive(0.0, encode(PUBLISHER, b""))
        told.append([payloads.decode_topic(payload) for _, payload in sent(device)[1:]])
    differing = {right.name for right, wrong_one in zip(*told) if right != wrong_one}
    # Of a sum that reads the same backwards there is no other.
    assert differing == ({name} if name == "in" else set())
