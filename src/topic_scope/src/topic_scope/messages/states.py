# Pure: knows no ROS.
"""States: texts, and whole numbers with names, read out of serialized messages.

A state is kept as the number of its text in a table, so that it is recorded as all samples are.
"""

import math
import struct
from typing import Dict, List, Optional, Sequence

import numpy

from topic_scope.messages.decoding import COUNT, NotThere, follow, steps_to
from topic_scope.messages.definitions import Record, Scalar, Text
from topic_scope.messages.fields import FieldError, Path, to_text, value_names_at

#: Most different texts of a trace, and most characters of each.
TEXTS, CHARACTERS = 1000, 300
_OTHER = "(another text)"


class StateTable:
    """The different texts that a trace has had.

    :ivar texts: by their numbers
    """

    def __init__(self, texts: Sequence[str] = ()) -> None:
        self.texts: List[str] = list(texts)
        self._numbers: Dict[str, int] = {text: number for number, text in enumerate(texts)}
        self._has_cut = False

    def number(self, text: str) -> int:
        """Return the number of a text; that of "(another text)" where the table is full."""
        if len(text) > CHARACTERS:
            text, self._has_cut = text[:CHARACTERS] + "…", True
        if text not in self._numbers:
            if len(self.texts) >= TEXTS:
                text = _OTHER
            if text not in self._numbers:
                self._numbers[text] = len(self.texts)
                self.texts.append(text)
        return self._numbers[text]

    def text(self, number: float) -> Optional[str]:
        """Return the text with a number; None for NaN."""
        return None if math.isnan(number) else self.texts[int(number)]

    @property
    def note(self) -> Optional[str]:
        """Texts that are not kept or cut, in words; None without such."""
        full = f"more than {TEXTS} different texts: the others are not kept"
        cut = f"texts are cut after {CHARACTERS} characters"
        told = [full] * (len(self.texts) > TEXTS) + [cut] * self._has_cut
        return "; ".join(told) or None


class StateDecoder:
    """Reads one state out of messages of one layout; used as a :class:`.Decoder` is.

    :param layout: layout of the messages
    :param path: where the text, or the number with names, stands
    :param table: gets the texts
    :raises FieldError: if neither stands there

    :ivar is_time: False
    """

    is_time = False

    def __init__(self, layout: Record, path: Path, table: StateTable) -> None:
        self._table = table
        self._steps, leaf = steps_to(layout, path)
        self._names = value_names_at(layout, path)
        if not isinstance(leaf, Text) and not self._names:
            raise FieldError(f"{to_text(path)} is neither a text nor a number with named values")
        self._struct = struct.Struct("<" + leaf.format) if isinstance(leaf, Scalar) else None

    def value(self, message: bytes) -> str:
        """Return the state in a message; the number itself where its value has no name.

        :raises NotThere: if an element on the way to it is not there
        :raises struct.error: if the message is cut off
        """
        place = follow(self._steps, message)
        if self._struct is not None:
            number = int(self._struct.unpack_from(message, place)[0])
            return self._names.get(number, str(number))
        length = COUNT.unpack_from(message, place)[0]
        data = message[place + COUNT.size : place + COUNT.size + length]
        if len(data) != length:
            raise struct.error("the text is cut off")
        return data.decode("utf-8", "replace")

    def decode(self, messages: Sequence[bytes]) -> numpy.ndarray:
        """Return the number of the state in each message, NaN where it is missing."""
        return numpy.array([self._decode_one(data) for data in messages], numpy.float64)

    def _decode_one(self, message: bytes) -> float:
        try:
            return self._table.number(self.value(message))
        except (NotThere, struct.error):
            return math.nan

    def rounding(self, _values: numpy.ndarray) -> int:
        """Return 1: nothing is rounded."""
        return 1

    def has(self, message: bytes) -> bool:
        """Return whether a message has all array elements of the path."""
        try:
            follow(self._steps, message)
        except (NotThere, struct.error):
            return False
        return True
