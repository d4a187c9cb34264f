# Pure: knows no ROS.
"""Source of a sample's time: receipt, or a stamp in the message.

A stamp that the user has selected is trusted: the sample is placed there, however late it is
received, provided that it counts from the epoch.

If the scope selects the source, and for fields that are not stamps, the time may be by another
clock: time since the start of a node, simulated time, the clock of another machine; see
:mod:`topic_scope.timing`.
"""

from typing import Optional, Sequence

import numpy

from topic_scope.messages.decoding import Decoder
from topic_scope.messages.message_layout import MessageLayout, Scalar
from topic_scope.messages.fields import FieldError, Path, leaf_at, to_path, to_text
from topic_scope.timing.clocks import ELSEWHERE_NS, Clocks
from topic_scope.timing.nanoseconds import NO_TIME, NS
from topic_scope.timing.topic_time import TopicTime

#: Timestamp sources of every message, and of messages with a header.
RECEIVED, STAMP = "received", "stamp"

_STAMP_PATH: Path = ("header", "stamp")
#: Time field of messages without a header, e.g. of signal_msg.
_FIELD_PATH: Path = ("time_x",)
#: Number of samples that determine the usual interval; multiple of it that is a gap; and shortest
#: gap by times of receipt [s].
_FEW, _MISSING, _LONGEST_DELAY_S = 4, 5.0, 0.25


def path_of(timestamp: str, layout: MessageLayout) -> Optional[Path]:
    """Return the path of the stamp in messages.

    :param timestamp: ``received``, ``stamp``, the name of a field, or empty for the best source: a
        header's stamp, else ``time_x``, else the time of receipt
    :param layout: layout of the messages
    :returns: path of the time; None for the time of receipt
    :raises FieldError: if the messages do not have this time
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
    """Return the name of a path that :func:`path_of` has returned."""
    return RECEIVED if path is None else STAMP if path == _STAMP_PATH else to_text(path)


def is_exact(timestamp: str, layout: MessageLayout) -> bool:
    """Return whether samples keep their stamps, whatever the scope's clock.

    :param timestamp: as for :func:`path_of`, which must have accepted it
    :param layout: layout of the messages
    :returns: True for a selected stamp; False for a source that the scope chose, and for
        numbers, which have their own zero
    """
    path = path_of(timestamp, layout) if timestamp else None
    leaf = None if path is None else leaf_at(layout, path)
    return isinstance(leaf, Scalar) and leaf.datatype == "time"


def topic_time(clocks: Clocks, timestamp: str, layout: MessageLayout) -> TopicTime:
    """Return the object that places the messages of a topic in time.

    :param clocks: clocks of all topics
    :param timestamp: as for :func:`path_of`, which must have accepted it
    :param layout: layout of the messages
    """
    exact = is_exact(timestamp, layout)
    return TopicTime(clocks, exact or path_of(timestamp, layout) == _STAMP_PATH, exact)


def correction(path: Optional[Path], offset: int) -> Optional[str]:
    """Describe the shift of stamps.

    :param path: path of the messages' times
    :param offset: added to them [ns]
    :returns: None if the offset is 0, or the times are not stamps
    """
    if path != _STAMP_PATH or offset == 0:
        return None
    if abs(offset) > ELSEWHERE_NS:
        return "stamps of another clock: shown at reception"
    side = "behind" if offset > 0 else "ahead"
    return f"stamps {abs(offset) / NS:.2f} s {side}: shown at reception"


def oddities(path: Optional[Path], time: TopicTime) -> Optional[str]:
    """Describe the shift of stamps, and stamps that contradict the others.

    :param path: path of the messages' times
    :param time: placement of the messages
    :returns: None if there are no such stamps
    """
    moved = correction(path, time.clock.offset) if time.has_stamps else None
    return "; ".join(filter(None, (moved, time.outliers.text))) or None


def read_times(decoder: Decoder, path: Path, messages: Sequence[bytes]) -> numpy.ndarray:
    """Return the stamps of messages.

    An unset stamp, NaN, or a time outside the range of clocks is not a time.

    :param decoder: decoder of the field at the path
    :param path: path of their times
    :param messages: the messages
    :returns: the times [ns], or NO_TIME
    """
    times = decoder.times(messages)
    if path == _STAMP_PATH and not times.all():
        times[times == 0] = NO_TIME
    return times


def longest_step(path: Optional[Path], times: numpy.ndarray) -> float:
    """Return the longest time between connected samples [s]; beyond it, several are missing.

    :param path: path of their times in the messages
    :param times: times of the latest samples, ascending [ns]
    """
    if len(times) < _FEW:
        return float(numpy.inf)
    steps, middle = times[1:] - times[:-1], (len(times) - 1) // 2
    several = _MISSING * int(numpy.partition(steps, middle)[middle]) / NS
    # Times of receipt vary with delays, without missing samples.
    return several if path is not None else max(several, _LONGEST_DELAY_S)


def _is_time(layout: MessageLayout, path: Path) -> bool:
    """Return whether a field is precise enough for a time."""
    try:
        leaf = leaf_at(layout, path)
    except FieldError:
        return False
    return isinstance(leaf, Scalar) and leaf.datatype in ("time", "float64")
