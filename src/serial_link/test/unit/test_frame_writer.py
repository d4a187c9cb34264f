"""Order and pace of frames that the sending thread or the writer thread writes."""

import logging
import math
import threading
from typing import Any, List

import pytest

from nodekit.testing.waiting import in_thread, wait_until
from serial_link.framing.frames import encode
from serial_link.hardware.ports import PortLost, PortStuck
from serial_link.host.counters import SENT, SENT_BYTES, STUCK, Counters
from serial_link.link.frame_writer import FrameWriter
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.payloads import STOP


class FakePort:
    """Port that records what it accepts."""

    name, gap = "port", 0.0

    def __init__(self, baud: int = 0) -> None:
        self.baud = baud
        self.written: List[bytes] = []
        #: Number of bytes that the port accepts without blocking, and the error that it raises.
        self.room = 10**6
        self.failure: Any = None

    def write_now(self, data: bytes) -> bool:
        if isinstance(self.failure, PortLost):
            raise self.failure
        if self.room:
            self.written.append(data[: self.room])
        if 0 < self.room < len(data):
            self.write(data[self.room :])
        return self.room > 0

    def write(self, data: bytes) -> None:
        if self.failure is not None:
            raise self.failure
        self.written.append(data)

    def close(self) -> None:
        pass


class Rig:
    """Writer whose thread waits for frames."""

    def __init__(self, baud: int = 0) -> None:
        self.port: Any = FakePort(baud)
        self.counters = Counters()
        self.writer = FrameWriter(self.port, self.counters, ThrottledLog(0.0))
        self.writer.open()
        self.is_over = threading.Event()
        self.thread = in_thread(self.run)
        self.wait_until_idle()

    def run(self) -> None:
        while not self.is_over.is_set():
            self.writer.write_next()

    def wait_until_idle(self) -> None:
        wait_until(lambda: self.writer.queue.is_idle, lambda: "the writer does not wait")

    def close(self) -> None:
        self.is_over.set()
        self.writer.close()
        self.thread.join(30.0)


@pytest.fixture
def rig() -> Any:
    made = Rig()
    yield made
    made.close()


def test_frame_is_written_by_the_sending_thread_and_counted(rig: Rig) -> None:
    assert rig.writer.write_now(b"one") and rig.port.written == [b"one"]
    rig.writer.queue.put(1, b"four")
    wait_until(lambda: rig.port.written == [b"one", b"four"], lambda: f"{rig.port.written}")
    wait_until(
        lambda: rig.writer.traffic == {SENT: 2, SENT_BYTES: 7}, lambda: f"{rig.writer.traffic}"
    )


def test_frame_is_not_written_before_one_that_waits_or_on_a_closed_port(rig: Rig) -> None:
    with rig.writer._port_lock:  # as during a write
        assert not rig.writer.write_now(b"one")
        rig.writer.queue.put(1, b"two")
        assert not rig.writer.write_now(b"three")
    rig.wait_until_idle()
    rig.writer.close_port()
    assert not rig.writer.write_now(b"four")
    rig.writer.queue.put(1, b"five")
    rig.wait_until_idle()
    assert rig.port.written == [b"two"]


def test_frames_wait_while_the_line_is_busy_and_the_newest_replaces_them() -> None:
    rig = Rig(baud=300)
    assert rig.writer.write_now(bytes(30))
    rig.writer._pacer._free_at = math.inf  # instead of one second
    for number in range(40):
        frame = b"%d" % number
        assert not rig.writer.write_now(frame)
        rig.writer.queue.put(1, frame, 1)
    rig.writer._pacer._free_at = 0.0
    rig.wait_until_idle()
    assert rig.port.written == [bytes(30), b"39"]
    rig.close()


def test_port_without_a_baud_rate_once_it_is_open_is_not_paced() -> None:
    rig = Rig(baud=300)
    rig.port.baud = 0
    rig.writer.open()
    assert rig.writer.write_now(bytes(30)) and rig.writer.write_now(bytes(30))
    rig.close()


def test_frame_that_the_port_does_not_accept_is_left_to_the_writer_thread(rig: Rig) -> None:
    assert rig.writer.write_now(b"three")
    rig.port.room = 0
    assert not rig.writer.write_now(b"one")
    assert rig.writer.traffic == {SENT: 1, SENT_BYTES: 5}


def test_long_frame_is_left_to_the_writer_thread(rig: Rig) -> None:
    assert not rig.writer.write_now(bytes(5000)) and not rig.port.written


def test_stuck_port_is_distinguished_from_a_lost_one(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    caplog.set_level(logging.WARNING, "rosout")
    rig.port.room, rig.port.failure = 2, PortStuck("no room")
    assert rig.writer.write_now(b"three")  # its rest is lost
    assert rig.counters.to_dict() == {STUCK: 1} and "no room" in caplog.text
    rig.port.failure = PortLost("gone")
    assert not rig.writer.write_now(b"three")
    assert rig.writer.traffic == {SENT: 0, SENT_BYTES: 0}
    rig.port.failure, rig.port.room = None, 100
    assert rig.writer.write_now(b"one")  # no lock is held


def test_queued_frame_that_a_stuck_port_refuses_is_counted_and_the_next_one_sent(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    caplog.set_level(logging.WARNING, "rosout")
    rig.port.failure = PortStuck("no room")
    rig.writer.queue.put(1, b"refused")
    wait_until(lambda: rig.counters.to_dict() == {STUCK: 1}, lambda: "it is not counted")
    rig.port.failure = None
    rig.writer.queue.put(1, b"next")
    wait_until(lambda: rig.port.written == [b"next"], lambda: f"{rig.port.written}")
    assert "no room" in caplog.text


def test_frame_does_not_overtake_a_queued_one() -> None:
    writer = FrameWriter(FakePort(), Counters(), ThrottledLog(0.0))  # type: ignore[arg-type]
    writer.open()
    writer.queue.put(1, b"first")
    assert not writer.write_now(b"second")


def test_stop_is_sent_in_place_of_waiting_frames_before_the_call_returns(rig: Rig) -> None:
    with rig.writer._port_lock:  # as during a write
        rig.writer.queue.put(1, b"waiting")
        stopping = in_thread(rig.writer.send_stop)
        stopping.join(0.1)
        assert stopping.is_alive()
    stopping.join(30.0)
    assert rig.port.written == [encode(STOP, b"")] * 2 and rig.writer._has_stopped.is_set()
    # A topic request of a thread that did not know of the end would start the board again.
    rig.writer.queue.put_reliable(b"request")
    rig.wait_until_idle()
    assert not rig.writer.write_now(b"at once")
    assert rig.port.written == [encode(STOP, b"")] * 2


def test_closed_writer_no_longer_waits_for_frames(rig: Rig) -> None:
    rig.writer.close()
    assert rig.writer.queue.wait(0.0)


class SlowPort(FakePort):
    """Port whose writes block until the test releases them."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.has_begun, self.may_end = threading.Event(), threading.Event()

    def write_now(self, data: bytes) -> bool:
        self.has_begun.set()
        assert self.may_end.wait(30.0)
        return super().write_now(data)


def test_frame_after_one_of_another_thread_keeps_the_pace() -> None:
    port: Any = SlowPort(baud=300)
    writer = FrameWriter(port, Counters(), ThrottledLog(0.0))
    writer.open()
    following = in_thread(writer.write_next)
    wait_until(lambda: writer.queue.is_idle, lambda: "the writer does not wait")
    sending = in_thread(lambda: writer.write_now(bytes(1000)))  # 33 s on the line
    assert port.has_begun.wait(30.0)
    asked, delay = threading.Event(), writer._pacer.delay
    writer._pacer.delay = lambda now: asked.set() or delay(now)  # type: ignore[method-assign]
    writer.queue.put(1, b"next")
    asked.wait(0.2)  # it must not ask yet
    port.may_end.set()
    sending.join(30.0)
    following.join(30.0)
    assert port.written == [bytes(1000)]
