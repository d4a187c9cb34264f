"""Frame receiver of a board: byte by byte, as a state table."""

from typing import Dict, List, NamedTuple

from serial_link.framing.frames import SYNC, VERSION, Frame

#: Expected next byte.
SYNC_BYTE, VERSION_BYTE = "sync", "version"
SIZE_LOW, SIZE_HIGH, SIZE_SUM = "size low", "size high", "size sum"
TOPIC_LOW, TOPIC_HIGH, MESSAGE, SUM = "topic low", "topic high", "message", "sum"
#: Incomplete frames are dropped after this time [s].
TIMEOUT_S = 0.02


class NextStates(NamedTuple):
    """Next states after a byte.

    :param if_good: expected next byte if this byte is valid
    :param if_bad: expected next byte if this byte is invalid
    """

    if_good: str
    if_bad: str = SYNC_BYTE


TABLE: Dict[str, NextStates] = {
    SYNC_BYTE: NextStates(VERSION_BYTE),
    VERSION_BYTE: NextStates(SIZE_LOW),
    SIZE_LOW: NextStates(SIZE_HIGH),
    SIZE_HIGH: NextStates(SIZE_SUM),
    SIZE_SUM: NextStates(TOPIC_LOW),
    TOPIC_LOW: NextStates(TOPIC_HIGH),
    TOPIC_HIGH: NextStates(MESSAGE),
    MESSAGE: NextStates(SUM),
    SUM: NextStates(SYNC_BYTE),
}


class Receiver:
    """State machine that assembles frames from the bytes that a board receives.

    :param input_size: largest message [bytes]; a real board would overwrite the memory behind its
        buffer with a longer one, this board drops and counts it

    :ivar mode: expected next byte
    :ivar other_versions: number of frames of another version that began
    :ivar too_long: number of messages beyond ``input_size``
    """

    def __init__(self, input_size: int) -> None:
        self.mode = SYNC_BYTE
        self.other_versions = self.too_long = 0
        self._input_size = input_size
        self._size = self._topic = self._sum = 0
        self._message = bytearray()
        self._began_at = 0.0

    def receive(self, now: float, data: bytes) -> List[Frame]:
        """Return the frames completed by these bytes.

        :param now: the time [s]
        :param data: bytes from the line
        """
        if self.mode != SYNC_BYTE and now > self._began_at + TIMEOUT_S:
            self.mode = SYNC_BYTE
        frames: List[Frame] = []
        for byte in data:
            if self.mode == SYNC_BYTE and byte == SYNC:
                self._began_at = now
            was = self.mode
            is_good = self._accept(byte)
            self.mode = TABLE[was].if_good if is_good else TABLE[was].if_bad
            if was == VERSION_BYTE and not is_good:
                self.other_versions += 1
            elif was == TOPIC_HIGH and self._size == 0:
                self.mode = SUM
            elif was == MESSAGE and len(self._message) < self._size:
                self.mode = MESSAGE
            elif was == SUM and is_good:
                frames.append(Frame(self._topic, bytes(self._message)))
        return frames

    def _accept(self, byte: int) -> bool:
        """Add a byte to the frame; return whether the byte is valid."""
        mode = self.mode
        self._sum += byte
        if mode == SYNC_BYTE:
            return byte == SYNC
        if mode == VERSION_BYTE:
            return byte == VERSION
        if mode == SIZE_LOW:
            self._size = self._sum = byte
            self._message.clear()
        elif mode == SIZE_HIGH:
            self._size += byte << 8
        elif mode == SIZE_SUM:
            is_whole = self._sum % 256 == 255
            self.too_long += is_whole and self._size > self._input_size
            return is_whole and self._size <= self._input_size
        elif mode == TOPIC_LOW:
            self._topic = self._sum = byte
        elif mode == TOPIC_HIGH:
            self._topic += byte << 8
        elif mode == MESSAGE:
            self._message.append(byte)
        else:
            return self._sum % 256 == 255
        return True
