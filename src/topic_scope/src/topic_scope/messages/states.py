# Pure: knows no ROS.
"""Decoder of states: texts, and integers with named values, in serialized messages.

A state is stored as the index of its text in a table, so that it is recorded like all samples.
"""

import math
import struct
from typing import Dict, List, Optional, Sequence

import numpy

from topic_scope.messages.decoding import COUNT, ElementMissing, follow, steps_to
from topic_scope.messages.message_layout import MessageLayout, Scalar, Text
from topic_scope.messages.fields import FieldError, Path, to_text, value_names_at

#: Most different texts of a trace, and most characters of each.
TEXTS, CHARACTERS = 1000, 300
_OTHER = "(another text)"


class StateTable:
    """Table of the distinct texts of a trace.

    :ivar texts: by their numbers
    """

    def __init__(self, texts: Sequence[str] = ()) -> None:
        self.texts: List[str] = list(texts)
        self._numbers: Dict[str, int] = {text: number for number, text in enumerate(texts)}
        self._has_cut = False

    def number(self, text: str) -> int:
        """Return the number of a text; the number of "(another text)" if the table is full."""
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
        """Return the text of a number; None for NaN."""
        return None if math.isnan(number) else self.texts[int(number)]

    @property
    def note(self) -> Optional[str]:
        """Description of dropped or shortened texts; None without any."""
        full = f"more than {TEXTS} different texts: the others are not kept"
        cut = f"texts are cut after {CHARACTERS} characters"
        notes = [full] * (len(self.texts) > TEXTS) + [cut] * self._has_cut
        return "; ".join(notes) or None


class StateDecoder:
    """Decoder of one state of messages of one layout; replaces a :class:`.Decoder`.

    :param layout: layout of the messages
    :param path: path of the text, or of the number with named values
    :param table: receives the texts
    :raises FieldError: if the path is neither

    :ivar is_time: False
    """

    is_time = False

    def __init__(self, layout: MessageLayout, path: Path, table: StateTable) -> None:
        self._table = table
        self._steps, leaf = steps_to(layout, path)
        self._names = value_names_at(layout, path)
        if not isinstance(leaf, Text) and not self._names:
            raise FieldError(f"{to_text(path)} is neither a text nor a number with named values")
        self._struct = struct.Struct("<" + leaf.format) if isinstance(leaf, Scalar) else None

    def value(self, message: bytes) -> str:
        """Return the state in a message; the number itself if its value has no name.

        :raises ElementMissing: if an array element of its path is missing
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
        """Return the number of the state in each message; NaN if it is missing."""
        return numpy.array([self._decode_one(data) for data in messages], numpy.float64)

    def _decode_one(self, message: bytes) -> float:
        try:
            return self._table.number(self.value(message))
        except (ElementMissing, struct.error):
            return math.nan

    def rounding(self, _values: numpy.ndarray) -> int:
        """Return 1: nothing is rounded."""
        return 1

    def has(self, message: bytes) -> bool:
        """Return whether a message has all array elements of the path."""
        try:
            follow(self._steps, message)
        except (ElementMissing, struct.error):
            return False
        return True
