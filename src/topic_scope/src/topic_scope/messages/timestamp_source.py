# Pure: knows no ROS.
"""Source of a sample's time: reception, or a stamp in the message.

A stamp that the user has named is what it says: the sample stands there, however late it comes, as
long as it counts from the epoch at all.

Where the scope chooses, and for fields that are no stamps, what a message says is by a clock of its
own: time since the start of a node, simulated time, the clock of another machine. Between that
clock and the scope's lies the median of what the latest messages show, so that what is usual in
their delay shifts a trace, and what is not does not bend it. Stamps are moved like that only where
they are far away at first; the page says so.
"""

from typing import List, Optional, Tuple

import numpy

from topic_scope.messages.definitions import Record, Scalar
from topic_scope.messages.fields import FieldError, Path, leaf_at, to_path, to_text

#: Names of times that every message has, and that messages with a header have.
RECEIVED, STAMP = "received", "stamp"

_STAMP_PATH: Path = ("header", "stamp")
#: The field of a message without a header that says when it was made, e.g. signal_msg's.
_FIELD_PATH: Path = ("time_x",)
#: How much of what was received counts for the median: s, and most messages.
_RECENT_S, _RECENT = 2.0, 2000
#: The clocks' difference is measured again if it has changed by more than this [s]: at first, and
#: when enough has been received. From then on a trace does not move for a machine that is busy.
TOLERANCE_S, SETTLED_S = 0.002, 0.1
#: Stamps within this at first are by the scope's clock, and are kept as they are [s].
SAME_CLOCK_S = 0.5
#: Stamps further away than this are not late, but count from elsewhere [s].
ELSEWHERE_S = 3600.0
#: A time so far before those that came earlier was set back, and is not just late [s].
BACK_S = 0.5
#: How many samples tell what is usual between them; how many times that is a gap; and how long one
#: is at least where the times are those of receipt [s].
_FEW, _MISSING, _LONGEST_DELAY_S = 4, 5.0, 0.25
#: Beyond this a number is no time [s].
_LARGEST = 1e11


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


def correction(path: Optional[Path], offset: float) -> Optional[str]:
    """Describe how stamps were moved.

    :param path: where the times of the messages stand
    :param offset: what was added to them [s]
    :returns: None where nothing was, or where the times are no stamps
    """
    if path != _STAMP_PATH or offset == 0.0:
        return None
    if abs(offset) > ELSEWHERE_S:
        return "stamps of another clock: shown at reception"
    side = "behind" if offset > 0.0 else "ahead"
    return f"stamps {abs(offset):.2f} s {side}: shown at reception"


def said_in(path: Optional[Path], own: numpy.ndarray) -> numpy.ndarray:
    """Return which messages have a valid stamp.

    An unset stamp is not a time, nor is NaN, or what is beyond all clocks.

    :param path: where their times stand
    :param own: these times [s]
    :returns: a truth value for each
    """
    said: numpy.ndarray = numpy.abs(own) <= _LARGEST
    return said & (own != 0.0) if path == _STAMP_PATH else said


def placed(
    path: Optional[Path], own: numpy.ndarray, received: numpy.ndarray, exact: bool = False
) -> "List[numpy.ndarray]":
    """Return when recorded messages were made, by the clock that recorded them.

    :param path: where their times stand
    :param own: these times [s]
    :param received: when they were recorded [s]; for stamps, since the epoch as these
    :param exact: whether they were made when they say; see :func:`is_exact`
    :returns: the times [s], in parts: each begins where the clock was set back
    """
    said = said_in(path, own)
    if exact and said.any() and abs(numpy.median((received - own)[said])) < ELSEWHERE_S:
        return [numpy.where(said & _is_near(own, received), own, received)]
    ends = numpy.flatnonzero(numpy.diff(own) < -BACK_S) + 1
    times = []
    for told, came in zip(numpy.split(own, ends), numpy.split(received, ends)):
        time = OwnClock(path)
        part, _ = time.convert(told, came)
        times.append(part + time.offset)
    return times


def longest_step(path: Optional[Path], times: numpy.ndarray) -> float:
    """Return how far apart samples of one line may be [s]: beyond that, several are missing.

    :param path: where their times stand in the messages
    :param times: when the latest samples were taken, ascending [s]
    """
    if len(times) < _FEW:
        return float(numpy.inf)
    steps, middle = times[1:] - times[:-1], (len(times) - 1) // 2
    several = _MISSING * float(numpy.partition(steps, middle)[middle])
    # What is received is received with delays, and nothing needs to be missing.
    return several if path is not None else max(several, _LONGEST_DELAY_S)


def _is_near(own: numpy.ndarray, received: numpy.ndarray) -> numpy.ndarray:
    """Return which stamps are plausible: one far ahead would push out all others."""
    near: numpy.ndarray = own - received <= ELSEWHERE_S
    return near


def _is_time(layout: Record, path: Path) -> bool:
    """Return whether a field is precise enough for a time."""
    try:
        leaf = leaf_at(layout, path)
    except FieldError:
        return False
    return isinstance(leaf, Scalar) and leaf.datatype in ("time", "float64")


class OwnClock:
    """Tells the times of a topic's messages by their own clock, and how far that is from here.

    :param path: where the time stands in the messages
    :param exact: whether a sample stands where its message says; see :func:`is_exact`
    :param before: time of the latest sample before, which went by the scope's clock [s]
    """

    def __init__(
        self, path: Optional[Path], exact: bool = False, before: float = -numpy.inf
    ) -> None:
        #: What is to be added to an own time to get the scope's [s].
        self.offset = 0.0
        #: Whether any message has said a time; else the time of receipt counts.
        self.is_said = False
        self._path = path
        self._exact = exact
        self._begin_anew()
        self._latest = before

    def _begin_anew(self) -> None:
        #: Whether stamps are by the scope's clock: decided by the first, so that none jumps.
        self._is_same: Optional[bool] = None
        self._latest = -numpy.inf
        self._recent = numpy.empty((2, 0))  # times of receipt, and differences
        self._settles_at = numpy.inf
        self._tolerance = TOLERANCE_S

    def convert(self, own: numpy.ndarray, received: numpy.ndarray) -> Tuple[numpy.ndarray, float]:
        """Convert the times of some messages, and take them into account for those that follow.

        :param own: what they say [s]; no message's is changed here
        :param received: when they were received [s]
        :returns: their times by the own clock, and by how much it was set back before them [s]:
            what came earlier is to be moved by that; 0 where it was not
        """
        said = said_in(self._path, own)
        back = 0.0
        if said.any() and self._is_same is None:
            self._middle(received[said] - own[said])
        if self._is_same:
            said &= _is_near(own, received)
        if self._exact and self._is_same:
            self.is_said = True
            return numpy.where(said, own, received), back
        if said.any():
            differences = received[said] - own[said]
            # What came before a first time, as without /clock, stands where it was received.
            is_first = not self.is_said and self._latest > -numpy.inf
            if is_first or own[said].max() < self._latest - BACK_S:
                before = self.offset
                self._begin_anew()
                self.offset = self._middle(differences)
                back = before - self.offset
            self.is_said = True
            self._latest = max(self._latest, float(own[said].max()))
            self._follow(received[said], differences)
        elif not self.is_said:
            self._latest = float(received.max(initial=self._latest))
        return numpy.where(said, own, received - self.offset), back

    def _middle(self, differences: numpy.ndarray) -> float:
        """Return how far the clocks are apart [s]."""
        median = float(numpy.median(differences))
        if self._is_same is None:
            most = ELSEWHERE_S if self._exact else SAME_CLOCK_S
            is_stamp = self._exact or self._path == _STAMP_PATH
            self._is_same = is_stamp and abs(median) < most
        return 0.0 if self._is_same else median

    def _follow(self, received: numpy.ndarray, differences: numpy.ndarray) -> None:
        recent = numpy.concatenate([self._recent, [received, differences]], axis=1)[:, -_RECENT:]
        self._recent = recent[:, recent[0].searchsorted(recent[0, -1] - _RECENT_S) :]
        self._settles_at = min(self._settles_at, received[0] + _RECENT_S)
        settles = received[-1] >= self._settles_at and self._tolerance != SETTLED_S
        if not settles and abs(differences - self.offset).max() <= self._tolerance:
            return  # nothing speaks against what is known: the median would take the time
        middle = self._middle(self._recent[1])
        if settles:
            self.offset, self._tolerance = middle, SETTLED_S
        if abs(middle - self.offset) > self._tolerance:
            self.offset = middle
