# Pure: knows no ROS.
"""The lines that a demo prints: who begins or ends, in which thread, and when."""

import re
from typing import Iterable, Iterator, NamedTuple, Optional

_ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
_LINE = re.compile(r"(\d+\.\d{3}) s +(\S+) +(\S+) #(\d+) (begins|ends)(?:: (.*))?$")


class Event(NamedTuple):
    """A call begins or ends.

    :param time: since the start of the node, s
    :param thread: name of the thread that makes the call
    :param who: what is called; one word
    :param number: which of its calls, from 1 on
    :param begins: whether it begins; it ends otherwise
    :param note: what the call is about, in one line; may be empty
    """

    time: float
    thread: str
    who: str
    number: int
    begins: bool
    note: str = ""

    def __str__(self) -> str:
        what = f"{self.who} #{self.number} {'begins' if self.begins else 'ends'}"
        line = f"{self.time:8.3f} s  {self.thread:<12}  {what}"
        return f"{line}: {self.note}" if self.note else line


def read(lines: Iterable[str]) -> Iterator[Event]:
    """Return the events in what a demo has printed; other lines are left out.

    :param lines: as a terminal shows them, with whatever the log puts before
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
