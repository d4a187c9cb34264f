"""Decoder of frames in bytes that may be cut, damaged or mixed with noise."""

from typing import Counter, List, Tuple

from serial_link.framing.frames import (
    BEFORE_PAYLOAD,
    HEADER,
    LONGEST,
    OVERHEAD,
    START,
    SYNC,
    Frame,
)

#: What may be wrong with what arrives: the checksum of a length, a length beyond all messages or
#: one that others begin within, the checksum of a message, a message that does not go on; and the
#: bytes that belong to no good frame.
LENGTH_CHECKSUM, LENGTH, CHECKSUM, CUT_OFF = "length checksum", "length", "checksum", "cut off"
GARBAGE = "garbage bytes"
#: What else may begin at a place: a good frame, or perhaps one, of which too little is here.
_GOOD, _WAITING = "good", "waiting"


class Decoder:
    """Decoder of frames. It raises nothing, and returns no frame with a wrong checksum.

    After a fault it goes on right behind the two bytes that began the bad frame, not behind its
    end: what the length says may be the very thing that is wrong. Where a length lies, what follows
    is waited for in vain, and swallowed; so a frame within which two whole good frames stand back
    to back counts as none. Two good messages after any damage, frames are found again, unless their
    own content looks like the beginning of a frame.

    How the bytes are cut into pieces makes no difference.

    :ivar faults: how often each kind of fault was seen, and how many bytes were garbage
    :ivar longest: a longer payload is a fault [bytes]
    """

    def __init__(self, longest: int = LONGEST) -> None:
        self.faults: Counter[str] = Counter()
        self.longest = longest
        self._buffer = bytearray()

    @property
    def is_waiting(self) -> bool:
        """Whether the rest of a frame is waited for."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> List[Frame]:
        """Return the frames that are whole now.

        :param data: what has arrived
        """
        self._buffer += data
        return self._extract_frames(is_over=False)

    def flush(self) -> List[Frame]:
        """Stop waiting for the rest of a frame, as nothing has come for too long.

        :returns: the frames that were hidden behind its beginning
        """
        frames = self._extract_frames(is_over=True)
        self.faults[GARBAGE] += len(self._buffer)
        self._buffer.clear()
        return frames

    def reset(self) -> None:
        """Forget the beginning of a frame: the port was closed meanwhile."""
        self._buffer.clear()

    def _extract_frames(self, is_over: bool) -> List[Frame]:
        """Return the whole frames, and keep what may become one; nothing if it is over."""
        buffer, position = self._buffer, 0
        frames: List[Frame] = []
        while position < len(buffer):
            start = buffer.find(SYNC, position)
            if start < 0:
                start = len(buffer)
            self.faults[GARBAGE] += start - position
            what, position = self._classify(start)
            if what == _WAITING:
                if not is_over or start == len(buffer):
                    position = start
                    break
                what, position = CUT_OFF, min(start + len(START), len(buffer))
            if what == _GOOD:
                topic_id = buffer[start + HEADER] + 256 * buffer[start + HEADER + 1]
                payload = bytes(buffer[start + BEFORE_PAYLOAD : position - 1])
                frames.append(Frame(topic_id, payload))
                continue
            if what != GARBAGE:
                self.faults[what] += 1
            self.faults[GARBAGE] += position - start
        del buffer[:position]
        return frames

    def _classify(self, start: int) -> Tuple[str, int]:
        """Tell what begins at a place, and where to go on."""
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
        return _GOOD, end

    def _has_two_frames(self, start: int, stop: int) -> bool:
        """Tell whether two whole good frames stand back to back within a part of what is here."""
        place = self._buffer.find(START, start, stop)
        while place >= 0:
            end = self._end_of_good(place, stop)
            if end and self._end_of_good(end, stop):
                return True
            place = self._buffer.find(START, place + 1, stop)
        return False

    def _end_of_good(self, start: int, stop: int) -> int:
        """Return where a whole good frame ends that begins at a place; 0 if none does."""
        buffer = self._buffer
        if stop - start < OVERHEAD or not buffer.startswith(START, start):
            return 0
        low, high, check = buffer[start + 2 : start + HEADER]
        size = low + 256 * high
        end = start + size + OVERHEAD
        if (low + high + check) % 256 != 255 or size > self.longest or end > stop:
            return 0
        return end if sum(buffer[start + HEADER : end]) % 256 == 255 else 0
