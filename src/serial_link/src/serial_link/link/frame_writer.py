"""Writer of frames to a board's port, paced to its line."""

import threading
import time
from typing import Any, Dict, Optional

import rospy

from serial_link.framing.frames import encode
from serial_link.hardware.ports import Port, PortLost, PortStuck
from serial_link.host import counters
from serial_link.host.baud_pacing import BaudPacer
from serial_link.host.counters import Counters
from serial_link.host.message_queue import MessageQueue
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.payloads import STOP

#: Longest wait for the line [s]; shutdown is noticed after it.
_LONGEST_WAIT_S = 0.25
#: Longest wait for a frame to send [s]; shutdown ends it.
_IDLE_S = 1.0
#: Longest frame that a sending thread writes itself [bytes]. It fits into the system's buffer, so
#: the thread does not block.
_LONGEST_NOW = 1024
#: Frame that stops the board's publishing.
_STOP_FRAME = encode(STOP, b"")
_STOP_S = 1.0
#: Time to the repetition of the stop [s]: rosserial's library drops a frame that its loop reads in
#: two parts more than 20 ms apart.
_REPEAT_S = 0.07


class FrameWriter:
    """Writer of queued frames while its port is open.

    :param port: of the board
    :param counts: counters of faults
    :param log: throttled log

    :ivar queue: frames to send
    """

    def __init__(self, port: Port, counts: Counters, log: ThrottledLog) -> None:
        self.queue = MessageQueue()
        self._port, self._counters, self._throttled_log = port, counts, log
        self._pacer = BaudPacer(port.baud)
        self._is_open = False
        self._sent = self._sent_bytes = 0
        self._is_over, self._has_stopped = threading.Event(), threading.Event()
        #: Held while writing and counting: after a close, another file may get the same descriptor.
        self._port_lock = threading.Lock()

    @property
    def traffic(self) -> Dict[str, int]:
        """Numbers of sent frames and bytes."""
        return {counters.SENT: self._sent, counters.SENT_BYTES: self._sent_bytes}

    def open(self) -> None:
        """Start writing, after the port was opened."""
        self._pacer = BaudPacer(self._port.baud)
        self._is_open = True

    def close_port(self) -> None:
        """Close the port between two frames."""
        self._is_open = False
        with self._port_lock:
            self._port.close()

    def close(self) -> None:
        """End all waits."""
        self._is_over.set()
        self.queue.close()

    def send_stop(self) -> None:
        """Stop the board's publishing, because the host ends; return when the frame is sent.

        No frame follows: a topic request would make the board publish again.
        """
        if self._is_open:
            self.queue.clear()
            self.queue.put_reliable(_STOP_FRAME)
            self._has_stopped.wait(_STOP_S)

    def write_now(self, frame: bytes) -> bool:
        """Send a frame in the calling thread, if the line is free and no other frame waits.

        :param frame: the frame
        :returns: whether the frame was sent; otherwise it must be queued
        """
        if len(frame) > _LONGEST_NOW:
            return False
        try:
            return self._write_if_free(frame)
        except PortStuck as error:  # a part was sent: do not queue the frame
            self._report_stuck(error)
            return True
        except PortLost:
            return False

    def _write_if_free(self, frame: bytes) -> bool:
        if not self._port_lock.acquire(blocking=False):
            return False
        try:
            if not self._may_write or not self.queue.is_idle:
                return False
            if self._pacer.delay(time.monotonic()) > 0.0 or not self._port.write_now(frame):
                return False
            self._record_write(frame)
            return True
        finally:
            self._port_lock.release()

    def write_next(self) -> None:
        """Send the next frame of the queue as soon as the line is free."""
        if not self.queue.wait(_IDLE_S):
            return
        with self._port_lock:  # held by a sending thread until it has recorded its frame
            delay = self._pacer.delay(time.monotonic())
        if delay > 0.0:
            self._is_over.wait(min(delay, _LONGEST_WAIT_S))
            return
        frame: Optional[Any] = self.queue.get(0.0)
        if frame is None or not self._may_write:
            return
        try:
            with self._port_lock:
                self._port.write(frame)
                self._record_write(frame)
                if frame is _STOP_FRAME:
                    self._is_over.wait(_REPEAT_S)
                    self._port.write(frame)
        except PortStuck as error:
            self._report_stuck(error)
        except PortLost:
            self._is_over.wait(_LONGEST_WAIT_S)  # the reader thread reports the cause
        else:
            if frame is _STOP_FRAME:
                self._has_stopped.set()

    @property
    def _may_write(self) -> bool:
        return self._is_open and not self._has_stopped.is_set()

    def _record_write(self, frame: bytes) -> None:
        self._pacer.record_write(time.monotonic(), len(frame))
        self._sent += 1
        self._sent_bytes += len(frame)

    def _report_stuck(self, error: PortStuck) -> None:
        self._counters.add(counters.STUCK)
        self._throttled_log.log(rospy.logwarn, str(error))
