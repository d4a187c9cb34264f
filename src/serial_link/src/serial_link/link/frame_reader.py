"""Reader of frames from a board's port: counts damaged frames, and diagnoses a silent board."""

from typing import Dict, List, NamedTuple

from serial_link.framing.decoder import Decoder
from serial_link.framing.frames import LONGEST, OVERHEAD, Frame
from serial_link.hardware.ports import Port
from serial_link.host import counters
from serial_link.host.connect_diagnosis import ConnectDiagnosis


class ReceivedFrames(NamedTuple):
    """Frames completed by one read, and whether bytes between them are damaged.

    :param frames: the frames, oldest first
    :param is_damaged: whether bytes between them are not a frame
    """

    frames: List[Frame]
    is_damaged: bool


class FrameReader:
    """Reader of frames while its port is open.

    :param port: of the board
    """

    def __init__(self, port: Port) -> None:
        self._port = port
        self._decoder, self._diagnosis = Decoder(), ConnectDiagnosis()
        self._arrived_at = 0.0
        self._received = self._received_bytes = self._damage = 0

    def open(self) -> None:
        """Begin with a newly opened port."""
        self._decoder.reset()
        self._decoder.longest = LONGEST
        self._diagnosis.clear()

    def accept_up_to(self, longest: int) -> None:
        """Set the length above which a frame counts as damaged.

        :param longest: size of the board's send buffer, for one frame [bytes]; 0 if it is unknown
        """
        self._decoder.longest = longest - OVERHEAD if longest > OVERHEAD else LONGEST

    @property
    def faults(self) -> Dict[str, int]:
        """Numbers of damaged frames, by type of damage."""
        return self._decoder.faults

    @property
    def traffic(self) -> Dict[str, int]:
        """Numbers of received frames and bytes."""
        return {counters.RECEIVED: self._received, counters.RECEIVED_BYTES: self._received_bytes}

    def receive(self, now: float, data: bytes) -> ReceivedFrames:
        """Return the frames that these bytes complete.

        :param now: the time [s]
        :param data: bytes from the port; empty after a timeout, which ends an incomplete frame
        """
        if data:
            self._arrived_at = now
            self._received_bytes += len(data)
            frames = self._decoder.feed(data)
        elif self._decoder.is_waiting and now - self._arrived_at > self._port.gap:
            frames = self._decoder.flush()
        else:
            return ReceivedFrames([], False)
        if not self._diagnosis.is_over:
            self._diagnosis.add(data, bool(frames))
        self._received += len(frames)
        before, self._damage = self._damage, sum(self._decoder.faults.values())
        return ReceivedFrames(frames, self._damage != before)

    def explain_silence(self) -> str:
        """Return why the board does not answer, from the bytes since the port was opened."""
        return self._diagnosis.explain(self._port.baud)
