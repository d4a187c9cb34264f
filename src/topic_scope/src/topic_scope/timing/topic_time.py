# Pure: knows no ROS.
"""Placement of one topic's messages in time by their stamps, despite clock jumps and outliers.

A sample is placed at its stamp, however late or early its message arrives. A single message does
not affect the others: a clock has been set only if the following messages confirm it.
"""

from typing import Callable, List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.timing.clocks import ELSEWHERE_NS, SAME_CLOCK_NS, Clock, Clocks
from topic_scope.timing.lag import SETTLED_NS, Lag, median
from topic_scope.timing.nanoseconds import NO_TIME, NS

#: A stamp that is older than earlier stamps by this is late, or its clock was set back [ns].
BACK_NS = NS // 2
#: A stamp further ahead is rejected unless others confirm it: the sample is placed at receipt [ns].
AHEAD_NS = 10 * NS
#: Messages that confirm that a clock was set, and the least time between them [ns]: a queue that
#: is emptied delivers many late messages together.
AGREE, AGREE_NS = 3, NS // 5
#: How long a message waits for others to confirm it [ns, usual intervals].
_PATIENCE_NS, _PATIENCE_STEPS = NS, 4
#: Highest speed of a simulation or a replay; and number of messages in a row that contradict all
#: earlier ones after which they are accepted.
_FASTEST, _STUBBORN = 20, 10
#: Longest part of received messages that enters an estimate of the lag together [ns].
_PART_NS = NS


class PlacedMessages(NamedTuple):
    """Messages of a topic, placed by one clock.

    :param clock: the clock
    :param times: their timestamps, by that clock [ns]
    :param newest: the latest plausible timestamp [ns]; the history of samples counts from
        there
    :param moved: shift of the times of earlier messages by this clock [ns], so that they are
        shown at the same times, and their line ends; 0 if the line continues
    """

    clock: Clock
    times: numpy.ndarray
    newest: int
    moved: int


class Outliers(NamedTuple):
    """Stamps of a topic that others contradict.

    :param late: number of stamps that arrived after much later stamps
    :param latest: largest delay of these [ns]
    :param early: number of stamps ahead of the usual lag, placed at their stamps
    :param rejected: number of implausible stamps, placed at receipt
    :param furthest: largest lead of these; negative if behind [ns]
    """

    late: int = 0
    latest: int = 0
    early: int = 0
    rejected: int = 0
    furthest: int = 0

    @property
    def text(self) -> str:
        """Their counts as text; empty without any."""
        words = []
        if self.late:
            words.append(f"{_count(self.late)} up to {self.latest / NS:.2f} s late")
        if self.early:
            words.append(f"{_count(self.early)} early")
        if self.rejected:
            side = "ahead" if self.furthest > 0 else "behind"
            far = f"up to {abs(self.furthest) / NS:.6g} s {side}"
            words.append(f"{_count(self.rejected)} {far}: shown at reception")
        return "; ".join(words)


class TopicTime:
    """Placement of the messages of a topic in time.

    :param clocks: clocks of all topics
    :param is_stamp: whether messages have stamps; otherwise numbers with an unknown zero
    :param is_exact: whether stamps that count from the epoch are not shifted

    :ivar clock: the clock of the stamps
    :ivar has_stamps: whether any message had a stamp; otherwise the time of receipt is used
    :ivar outliers: contradicted stamps
    """

    def __init__(self, clocks: Clocks, is_stamp: bool = True, is_exact: bool = False) -> None:
        self.clock = clocks.scope
        self.has_stamps = False
        self.outliers = Outliers()
        self._clocks, self._is_stamp, self._is_exact = clocks, is_stamp, is_exact
        self._lag = Lag()
        self._attached_at = 0
        self._newest = NO_TIME
        self._step = self._alone = self._moved = 0
        #: Function that returns the chosen clock; None to estimate the clock.
        self._chosen_clock: Optional[Callable[[], Clock]] = None
        #: Delay of messages relative to the chosen clock [ns].
        self._delay = 0
        #: Offset of the clock when it was last set [ns]; None before.
        self._jumped_to: Optional[int] = None

    @property
    def patience(self) -> int:
        """Time that messages wait for others to confirm them [ns]."""
        return max(_PATIENCE_NS, _PATIENCE_STEPS * self._step)

    def choose(self, clock: Optional[Callable[[], Clock]]) -> None:
        """Use the clock of another topic, without affecting it, or estimate the clock again.

        All samples are placed again, including earlier ones.

        :param clock: function that returns the clock; None to estimate it
        """
        self._chosen_clock = clock
        if not self.has_stamps:
            return
        if clock is not None:
            self.clock.members.discard(self._lag)
            self.clock = clock()
            self._delay = self._lag.usual - self.clock.offset
        else:
            received, stamps = self._lag.recent()
            self._attach(stamps, received)
        self._moved = 0

    def _follow(self, clock: Clock, own: numpy.ndarray, received: numpy.ndarray) -> None:
        """Switch to a chosen clock that was set, as soon as the stamps follow it.

        Earlier samples keep their places.
        """
        there = own != NO_TIME
        if clock is self.clock or not there.any():
            return
        apart = median((received - own)[there]) - self._delay
        if abs(apart - clock.offset) < abs(apart - self.clock.offset):
            self._moved += self.clock.offset - clock.offset
            self.clock = clock

    def _follows_chosen(
        self, own: numpy.ndarray, received: numpy.ndarray, left: Optional[Clock]
    ) -> bool:
        """Return whether stamps follow the chosen clock.

        After the clock was set, they do not until a message of the other topic is received.
        """
        if self._chosen_clock is None:
            return False
        self._follow(self._chosen_clock(), own, received)
        apart = median(received - own) - self._delay
        return left is None or abs(apart - self.clock.offset) <= BACK_NS

    def place(
        self, own: numpy.ndarray, received: numpy.ndarray, is_final: bool = False
    ) -> List[PlacedMessages]:
        """Place messages in time.

        :param own: their stamps [ns], or NO_TIME
        :param received: when they were received, ascending [ns]
        :param is_final: whether they do not wait for others
        :returns: their times in parts. Messages at the end that are in no part wait for others, and
            must precede the messages of the next call
        """
        placed: List[PlacedMessages] = []
        start = stop = 0
        if self._chosen_clock is not None:
            self._follow(self._chosen_clock(), own, received)
        while start < len(own):
            stop = max(stop, int(received.searchsorted(received[start] + _PART_NS, "right")))
            some = slice(start, stop)
            if not self.has_stamps:
                self._attach_first(own[some], received[some])
            if start == 0 and stop == len(own) and self._is_usual(own, received):
                return [self._accepted(own, received, 0)]
            is_odd, is_early = self._contradicted(own[some], received[some])
            odd = is_odd.nonzero()[0]
            usual = int(odd[0]) if len(odd) else stop - start
            if usual:
                good = slice(start, start + usual)
                early = is_early[:usual]
                placed.append(self._accepted(own[good], received[good], int(early.sum()), early))
                start += usual
                continue
            end = start + _leading(is_odd)
            run = own[start:end], received[start:end]
            agreeing = self._agreeing(*run, is_final and end == len(own))
            if agreeing:
                self._jump(run[0][:agreeing], run[1][:agreeing])
                placed.append(self._accepted(run[0][:agreeing], run[1][:agreeing], 0))
                start += agreeing
            elif end < stop or (
                end == len(own) and (is_final or received[-1] - received[start] > self.patience)
            ):
                placed.append(self._placed_alone(*run))
                start = end
            elif end == len(own):
                break
            else:
                stop = int(received.searchsorted(received[stop] + _PART_NS, "right"))
        return placed

    def _is_usual(self, own: numpy.ndarray, received: numpy.ndarray) -> bool:
        """Return whether all stamps are in order and as expected: the fast path."""
        if not self.has_stamps:
            return bool((own == NO_TIME).all())
        ahead = own - received
        usual = self._expected(received[:1])[0]
        return bool(
            own[0] >= self._newest
            and (own[1:] >= own[:-1]).all()
            and ahead.max() + usual <= BACK_NS
            and ahead.min() + usual >= -ELSEWHERE_NS
            and not self._lag.drift
        )

    def _expected(self, received: numpy.ndarray) -> numpy.ndarray:
        """Return the least expected lag of stamps [ns].

        By the scope's own clock, a stamp with less lag than others is not early.
        """
        usual = self._lag.expected_of(received)
        return numpy.minimum(usual, 0) if self.clock.is_scope else usual

    def _contradicted(
        self, own: numpy.ndarray, received: numpy.ndarray
    ) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """Return masks of stamps that contradict earlier ones, and of early stamps."""
        ahead = own - received + self._expected(received)
        rate = max(1.0, 1.0 - self._lag.drift)
        is_early = ahead > BACK_NS * rate
        there = own != NO_TIME
        believed = numpy.where(is_early, NO_TIME, own)
        newest = numpy.maximum.accumulate(numpy.maximum(believed, self._newest))
        is_odd = (newest - own > BACK_NS) & there & ~is_early
        is_odd |= there & ((ahead > AHEAD_NS * rate) | (ahead < -ELSEWHERE_NS))
        return is_odd, is_early & there

    def _agreeing(self, own: numpy.ndarray, received: numpy.ndarray, is_last: bool) -> int:
        """Return the number of messages that confirm that their clock was set; 0 if they do not.

        :param is_last: whether no messages will follow
        """
        there = (own != NO_TIME).nonzero()[0]
        if len(there) >= AGREE:
            long_enough = received[there] - received[there[0]] >= AGREE_NS
            long_enough[: AGREE - 1] = False
            ends = long_enough.nonzero()[0]
            if len(ends):
                there = there[: int(ends[0]) + 1]
            elif self._alone < _STUBBORN:
                return 0
        elif not (is_last and len(there) >= 2) and self._alone < _STUBBORN:
            return 0
        agrees = self._alone >= _STUBBORN or _is_steady(own[there], received[there])
        return int(there[-1]) + 1 if agrees else 0

    def _attach_first(self, own: numpy.ndarray, received: numpy.ndarray) -> None:
        there = own != NO_TIME
        if there.any():
            self.has_stamps = True
            self._attach(own[there], received[there])
            if self._is_exact and self.clock.is_scope and self._lag.usual < -AHEAD_NS:
                self._lag.begin(0, int(received[0]))  # accepted only if others confirm it

    def _attach(
        self, own: numpy.ndarray, received: numpy.ndarray, left: Optional[Clock] = None
    ) -> None:
        """Switch to the clock of some stamps.

        :param left: the previous clock, which they no longer follow
        """
        self.clock.members.discard(self._lag)
        if not self._follows_chosen(own, received, left):
            before = self.clock.offset
            self.clock = self._clocks.find(own, received, self._is_stamp, self._is_exact, left)
            self._moved += before - self.clock.offset
        self._attached_at = median(received - own)
        self._lag.begin(self._attached_at, int(received[-1]))
        if self._chosen_clock is None:
            self.clock.members.add(self._lag)
        self._clocks.changes += 1

    def _jump(self, own: numpy.ndarray, received: numpy.ndarray) -> None:
        """Switch to another clock, or to the same clock after it was set."""
        there = own != NO_TIME
        self.clock.members.discard(self._lag)
        self._lag, self._newest = Lag(), NO_TIME
        self._attach(own[there], received[there], None if self.clock.is_scope else self.clock)
        self._jumped_to = self.clock.offset

    def _accepted(
        self,
        own: numpy.ndarray,
        received: numpy.ndarray,
        early: int,
        is_early: Optional[numpy.ndarray] = None,
    ) -> PlacedMessages:
        """Place messages at their stamps, or at receipt without a stamp.

        :param early: number of early stamps
        :param is_early: mask of the early stamps, if any
        """
        self._alone = 0
        moved, self._moved = self._moved, 0
        if not self.has_stamps:
            return PlacedMessages(self.clock, received, int(received[-1]), 0)
        if int(own.min()) > NO_TIME:
            self._learn(own, received)
            times = own
        else:
            there = own != NO_TIME
            if there.any():
                self._learn(own[there], received[there])
            times = numpy.where(there, own, received - self.clock.offset)
        if early and is_early is not None:
            self.outliers = self.outliers._replace(early=self.outliers.early + early)
            own = own[~is_early]
        self._newest = max(self._newest, int(own.max(initial=NO_TIME)))
        return PlacedMessages(self.clock, times, self._newest, moved)

    def _learn(self, stamps: numpy.ndarray, received: numpy.ndarray) -> None:
        """Update the usual lag with messages."""
        lag = self._lag
        self._step = (int(received[-1]) - (lag.received or int(received[0]))) // len(stamps)
        was_settled = lag.is_settled
        has_changed = lag.add(received, received - stamps)
        # Other topics of the clock, which determined its offset, may be silent by now.
        if not has_changed and abs(lag.usual - self.clock.offset) <= SETTLED_NS:
            return
        if lag.is_settled and not was_settled and not lag.drift:
            if abs(lag.usual - self._attached_at) > SAME_CLOCK_NS:
                # The first messages were not typical.
                self._attach(stamps, received)
                before = self._jumped_to  # samples from before the clock was set stay
                self._moved = 0 if before is None else before - self.clock.offset
        if self._chosen_clock is None:
            self._clocks.follow(self.clock, lag.received)

    def _placed_alone(self, own: numpy.ndarray, received: numpy.ndarray) -> PlacedMessages:
        """Place messages that no others confirm, at their stamps if these are plausible."""
        self._alone += len(own)
        there = own != NO_TIME
        ahead = own - received + self._expected(received)
        is_rejected = there & ((ahead > AHEAD_NS) | (ahead < -ELSEWHERE_NS))
        is_late = there & ~is_rejected
        before = self.outliers
        rejected = ahead[is_rejected]
        furthest = [before.furthest, *rejected.tolist()]
        late = int((-ahead[is_late]).max(initial=0))
        self.outliers = before._replace(
            late=before.late + int(is_late.sum()),
            latest=max(before.latest, late),
            rejected=before.rejected + len(rejected),
            furthest=max(furthest, key=abs),
        )
        times = numpy.where(is_late, own, received - self.clock.offset)
        return PlacedMessages(self.clock, times, self._newest, 0)


def _is_steady(own: numpy.ndarray, received: numpy.ndarray) -> bool:
    """Return whether stamps rise as those of one clock: the lags of late messages differ."""
    since, apart = received - received[0], received - own
    moved = apart[-1] - apart[0]
    drift = moved / max(since[-1], 1)
    is_even = numpy.abs(apart - apart[0] - drift * since).max() <= BACK_NS
    # Two messages may arrive together.
    is_slow = abs(moved) <= BACK_NS + _FASTEST * since[-1]
    return bool(own[-1] >= own[0] and is_slow and is_even)


def _leading(truths: numpy.ndarray) -> int:
    """Return the number of leading true values."""
    others = (~truths).nonzero()[0]
    return int(others[0]) if len(others) else len(truths)


def _count(number: int) -> str:
    return f"{number} stamp" if number == 1 else f"{number} stamps"
