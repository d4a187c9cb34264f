"""Frame decoder for byte streams that may be cut off, damaged or noisy."""

from typing import Counter, List, Optional, Tuple

from serial_link.framing.frames import (
    BEFORE_PAYLOAD,
    HEADER,
    LONGEST,
    OVERHEAD,
    START,
    SYNC,
    VERSION,
    Frame,
)

#: Faults: wrong checksum of a length; a length beyond all messages, or a frame that overlaps
#: others; wrong checksum of a message; a message that breaks off. And the number of bytes outside
#: good frames.
LENGTH_CHECKSUM, LENGTH, CHECKSUM, CUT_OFF = "length checksum", "length", "checksum", "cut off"
GARBAGE = "garbage bytes"
#: Other classifications of a position: a good frame, or an incomplete one.
_GOOD, _WAITING = "good", "waiting"
#: After a fault or garbage, the line counts as noisy for this many good frames.
NOISY_FRAMES = 1000


class Decoder:
    """Frame decoder. It raises no exception, and returns no frame with a wrong checksum.

    After a fault it continues right behind the two start bytes of the bad frame, not behind its
    end, because the length itself may be wrong. A wrong length would make it wait for bytes that
    never arrive, and swallow good frames; so a frame that contains two good frames back to back is
    invalid. At most two good messages after a fault, frames are recognised again, unless their
    content looks like the beginning of a frame.

    Where a byte 0xff was lost in a frame, the first byte of the next frame, 0xff, completes it, and
    as checksum makes up for the lost one. So on a noisy line, a frame that ends with 0xff is good
    only if the version byte does not follow; the decoder waits for that byte.

    The result does not depend on how the bytes are split into pieces.

    :ivar faults: number of faults by type, and of garbage bytes
    :ivar longest: longest valid payload [bytes]
    """

    def __init__(self, longest: int = LONGEST) -> None:
        self.faults: Counter[str] = Counter()
        self.longest = longest
        self._buffer = bytearray()
        #: Good frames to come until the line no longer counts as noisy.
        self._noisy_frames = 0

    @property
    def is_waiting(self) -> bool:
        """Whether a frame is incomplete."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> List[Frame]:
        """Return the frames completed by these bytes.

        :param data: the received bytes
        """
        if not self._buffer and not self._noisy_frames:
            frame = self._single_frame(data)
            if frame is not None:
                return [frame]
        self._buffer += data
        return self._extract_frames(is_over=False)

    def _single_frame(self, data: bytes) -> Optional[Frame]:
        """Return the frame if the bytes are exactly one good frame, else None.

        A read usually returns one frame; this check takes a third of the time of the search.
        """
        size = len(data) - OVERHEAD
        if not 0 <= size <= self.longest or data.rfind(START) != 0:
            return None
        low, high, check, id_low, id_high = data[len(START) : BEFORE_PAYLOAD]
        if low + 256 * high != size or (low + high + check) % 256 != 255:
            return None
        if sum(data[HEADER:]) % 256 != 255:
            return None
        return Frame(id_low + 256 * id_high, data[BEFORE_PAYLOAD:-1])

    def flush(self) -> List[Frame]:
        """Give up on an incomplete frame after a timeout.

        :returns: the frames that were hidden behind its beginning
        """
        return self._extract_frames(is_over=True)

    def reset(self) -> None:
        """Drop an incomplete frame, after the port was closed."""
        self._buffer.clear()

    def _extract_frames(self, is_over: bool) -> List[Frame]:
        """Return the complete frames, and keep an incomplete one, unless ``is_over``."""
        buffer, position = self._buffer, 0
        frames: List[Frame] = []
        while position < len(buffer):
            start = buffer.find(SYNC, position)
            if start < 0:
                start = len(buffer)
            if start > position:  # such as the rest of a frame whose first byte completed another
                self.faults[GARBAGE] += start - position
                self._noisy_frames = NOISY_FRAMES
            kind, position = self._classify(start, is_over)
            if kind == _WAITING:
                if not is_over or start == len(buffer):
                    position = start
                    break
                kind, position = CUT_OFF, min(start + len(START), len(buffer))
            if kind == _GOOD:
                topic_id = buffer[start + HEADER] + 256 * buffer[start + HEADER + 1]
                payload = bytes(buffer[start + BEFORE_PAYLOAD : position - 1])
                frames.append(Frame(topic_id, payload))
                if self._noisy_frames:
                    self._noisy_frames -= 1
                continue
            if kind != GARBAGE:
                self.faults[kind] += 1
            self._noisy_frames = NOISY_FRAMES
            self.faults[GARBAGE] += position - start
        del buffer[:position]
        return frames

    def _classify(self, start: int, is_over: bool) -> Tuple[str, int]:
        """Classify a position; return the class, and the position to continue at."""
        buffer = self._buffer
        if not START.startswith(buffer[start : start + len(START)]):
            return GARBAGE, start + 1
        if len(buffer) - start < HEADER:
            return _WAITING, start
        low, high, check = buffer[start + len(START) : start + HEADER]
        behind = start + len(START)
        if (low + high + check) % 256 != 255:
            return LENGTH_CHECKSUM, behind
        size = low + 256 * high
        if size > self.longest:
            return LENGTH, behind
        end = start + size + OVERHEAD
        if self._has_two_frames(behind, min(end, len(buffer))):
            return LENGTH, behind
        if end > len(buffer):
            return _WAITING, start
        if sum(buffer[start + HEADER : end]) % 256 != 255:
            return CHECKSUM, behind
        if self._noisy_frames and buffer[end - 1] == SYNC:
            if end == len(buffer) and not is_over:
                return _WAITING, start
            if buffer[end : end + 1] == bytes((VERSION,)):
                return CHECKSUM, behind
        return _GOOD, end

    def _has_two_frames(self, start: int, stop: int) -> bool:
        """Return whether a range contains two good frames back to back."""
        if stop - start < 2 * OVERHEAD:
            return False
        place = self._buffer.find(START, start, stop)
        while place >= 0:
            end = self._end_of_good(place, stop)
            if end and self._end_of_good(end, stop):
                return True
            place = self._buffer.find(START, place + 1, stop)
        return False

    def _end_of_good(self, start: int, stop: int) -> int:
        """Return the end of a good frame that begins at a position; 0 if there is no good frame."""
        buffer = self._buffer
        if stop - start < OVERHEAD or not buffer.startswith(START, start):
            return 0
        low, high, check = buffer[start + 2 : start + HEADER]
        size = low + 256 * high
        end = start + size + OVERHEAD
        if (low + high + check) % 256 != 255 or size > self.longest or end > stop:
            return 0
        return end if sum(buffer[start + HEADER : end]) % 256 == 255 else 0
