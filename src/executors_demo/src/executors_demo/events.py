# Pure: knows no ROS.
"""Lines that a demo prints: start or end of a call, its thread, and the time."""

import re
from typing import Iterable, Iterator, NamedTuple, Optional

_ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
_LINE = re.compile(r"(\d+\.\d{3}) s +(\S+) +(\S+) #(\d+) (begins|ends)(?:: (.*))?$")


class Event(NamedTuple):
    """Start or end of a call.

    :param time: since the start of the node [s]
    :param thread: name of the calling thread
    :param who: name of the callback, one word
    :param number: sequence number of the call, from 1
    :param begins: whether it starts; otherwise it ends
    :param note: subject of the call, in one line; may be empty
    """

    time: float
    thread: str
    who: str
    number: int
    begins: bool
    note: str = ""

    def __str__(self) -> str:
        call = f"{self.who} #{self.number} {'begins' if self.begins else 'ends'}"
        line = f"{self.time:8.3f} s  {self.thread:<12}  {call}"
        return f"{line}: {self.note}" if self.note else line


def read(lines: Iterable[str]) -> Iterator[Event]:
    """Yield the events in the output of a demo; other lines are ignored.

    :param lines: as shown by a terminal, with any prefix of the log
    """
    for line in lines:
        event = _event(line)
        if event is not None:
            yield event


def _event(line: str) -> Optional[Event]:
    found = _LINE.search(_ESCAPES.sub("", line).rstrip())
    if found is None:
        return None
    time, thread, who, number, verb, note = found.groups()
    return Event(float(time), thread, who, int(number), verb == "begins", note or "")
