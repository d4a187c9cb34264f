# Pure: knows no ROS.
"""Source of a sample's time: reception, or a stamp in the message.

A stamp that the user has named is what it says: the sample stands there, however late it comes, as
long as it counts from the epoch at all.

Where the scope chooses, and for fields that are no stamps, what a message says may be by another
clock: time since the start of a node, simulated time, the clock of another machine; see
:mod:`topic_scope.timing`.
"""

from typing import Optional, Sequence

import numpy

from topic_scope.messages.decoding import Decoder
from topic_scope.messages.definitions import Record, Scalar
from topic_scope.messages.fields import FieldError, Path, leaf_at, to_path, to_text
from topic_scope.timing.clocks import ELSEWHERE_NS, Clocks
from topic_scope.timing.nanoseconds import NO_TIME, NS
from topic_scope.timing.topic_time import TopicTime

#: Names of times that every message has, and that messages with a header have.
RECEIVED, STAMP = "received", "stamp"

_STAMP_PATH: Path = ("header", "stamp")
#: The field of a message without a header that says when it was made, e.g. signal_msg's.
_FIELD_PATH: Path = ("time_x",)
#: How many samples tell what is usual between them; how many times that is a gap; and how long one
#: is at least where the times are those of receipt [s].
_FEW, _MISSING, _LONGEST_DELAY_S = 4, 5.0, 0.25


def path_of(timestamp: str, layout: Record) -> Optional[Path]:
    """Return where messages say when they were made.

    :param timestamp: ``received``, ``stamp``, the name of a field, or nothing for what fits best: a
        header's stamp, else ``time_x``, else the time of receipt
    :param layout: layout of the messages
    :returns: where the time stands; None where the time of receipt counts
    :raises FieldError: if there is no such time in the messages
    """
    if timestamp == RECEIVED:
        return None
    if not timestamp:
        wanted = [path for path in (_STAMP_PATH, _FIELD_PATH) if _is_time(layout, path)]
        return wanted[0] if wanted else None
    path = _STAMP_PATH if timestamp == STAMP else to_path(timestamp)
    if not _is_time(layout, path):
        raise FieldError(f"there is no time {to_text(path)} in {layout.datatype}")
    return path


def name_of(path: Optional[Path]) -> str:
    """Return the name of a time that :func:`path_of` has returned."""
    return RECEIVED if path is None else STAMP if path == _STAMP_PATH else to_text(path)


def is_exact(timestamp: str, layout: Record) -> bool:
    """Return whether samples keep their stamps, whatever the scope's clock.

    :param timestamp: as for :func:`path_of`, which has to have accepted it
    :param layout: layout of the messages
    :returns: True for a stamp that was named; False for what was chosen for want of a name, and for
        numbers, which count from a zero of their own
    """
    path = path_of(timestamp, layout) if timestamp else None
    leaf = None if path is None else leaf_at(layout, path)
    return isinstance(leaf, Scalar) and leaf.datatype == "time"


def topic_time(clocks: Clocks, timestamp: str, layout: Record) -> TopicTime:
    """Return what places the messages of a topic in time.

    :param clocks: those of all topics
    :param timestamp: as for :func:`path_of`, which has to have accepted it
    :param layout: layout of the messages
    """
    exact = is_exact(timestamp, layout)
    return TopicTime(clocks, exact or path_of(timestamp, layout) == _STAMP_PATH, exact)


def correction(path: Optional[Path], offset: int) -> Optional[str]:
    """Describe how stamps were moved.

    :param path: where the times of the messages stand
    :param offset: what was added to them [ns]
    :returns: None where nothing was, or where the times are no stamps
    """
    if path != _STAMP_PATH or offset == 0:
        return None
    if abs(offset) > ELSEWHERE_NS:
        return "stamps of another clock: shown at reception"
    side = "behind" if offset > 0 else "ahead"
    return f"stamps {abs(offset) / NS:.2f} s {side}: shown at reception"


def oddities(path: Optional[Path], time: TopicTime) -> Optional[str]:
    """Describe how stamps were moved, and which contradict the others.

    :param path: where the times of the messages stand
    :param time: places them
    :returns: None where all is usual
    """
    moved = correction(path, time.clock.offset) if time.has_stamps else None
    return "; ".join(filter(None, (moved, time.outliers.text))) or None


def read_times(decoder: Decoder, path: Path, messages: Sequence[bytes]) -> numpy.ndarray:
    """Return when messages say that they were made.

    An unset stamp is not a time, nor is NaN, or what is beyond all clocks.

    :param decoder: reads the field at the path
    :param path: where their times stand
    :param messages: the messages
    :returns: the times [ns], or NO_TIME
    """
    times = decoder.times(messages)
    if path == _STAMP_PATH and not times.all():
        times[times == 0] = NO_TIME
    return times


def longest_step(path: Optional[Path], times: numpy.ndarray) -> float:
    """Return how far apart samples of one line may be [s]: beyond that, several are missing.

    :param path: where their times stand in the messages
    :param times: when the latest samples were taken, ascending [ns]
    """
    if len(times) < _FEW:
        return float(numpy.inf)
    steps, middle = times[1:] - times[:-1], (len(times) - 1) // 2
    several = _MISSING * int(numpy.partition(steps, middle)[middle]) / NS
    # What is received is received with delays, and nothing needs to be missing.
    return several if path is not None else max(several, _LONGEST_DELAY_S)


def _is_time(layout: Record, path: Path) -> bool:
    """Return whether a field is precise enough for a time."""
    try:
        leaf = leaf_at(layout, path)
    except FieldError:
        return False
    return isinstance(leaf, Scalar) and leaf.datatype in ("time", "float64")
