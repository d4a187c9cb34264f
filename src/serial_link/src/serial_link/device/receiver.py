"""Frame receiver of a board: byte by byte, by a table of the expected bytes."""

from typing import Dict, List, NamedTuple

from serial_link.framing.frames import SYNC, VERSION, Frame

#: What the next byte is.
SYNC_BYTE, VERSION_BYTE = "sync", "version"
SIZE_LOW, SIZE_HIGH, SIZE_SUM = "size low", "size high", "size sum"
TOPIC_LOW, TOPIC_HIGH, MESSAGE, SUM = "topic low", "topic high", "message", "sum"
#: A frame that is not whole by then is dropped [s].
TIMEOUT_S = 0.02


class Expected(NamedTuple):
    """States that follow a byte.

    :param if_good: what the next byte is then
    :param if_bad: and what, where the byte is not what it must be
    """

    if_good: str
    if_bad: str = SYNC_BYTE


TABLE: Dict[str, Expected] = {
    SYNC_BYTE: Expected(VERSION_BYTE),
    VERSION_BYTE: Expected(SIZE_LOW),
    SIZE_LOW: Expected(SIZE_HIGH),
    SIZE_HIGH: Expected(SIZE_SUM),
    SIZE_SUM: Expected(TOPIC_LOW),
    TOPIC_LOW: Expected(TOPIC_HIGH),
    TOPIC_HIGH: Expected(MESSAGE),
    MESSAGE: Expected(SUM),
    SUM: Expected(SYNC_BYTE),
}


class Receiver:
    """A board's end of the line.

    :param input_size: a longer message does not fit [bytes]; a real board would overwrite what lies
        behind its buffer, this one drops and counts it

    :ivar mode: what the next byte is
    :ivar other_versions: how often a frame of another version began
    :ivar too_long: how many frames had a message that does not fit
    """

    def __init__(self, input_size: int) -> None:
        self.mode = SYNC_BYTE
        self.other_versions = self.too_long = 0
        self._input_size = input_size
        self._size = self._topic = self._sum = 0
        self._message = bytearray()
        self._began_at = 0.0

    def receive(self, now: float, data: bytes) -> List[Frame]:
        """Return the frames that are whole now.

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
        """Add a byte to the frame; return whether it is what it must be."""
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
