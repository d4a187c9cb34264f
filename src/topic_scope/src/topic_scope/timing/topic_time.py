# Pure: knows no ROS.
"""Times of the messages of one topic, by the clock that their stamps follow.

A sample stands at its stamp, however late or early its message comes. What a single message says
changes nothing for the others: a clock was set only where the messages after it agree.
"""

from typing import List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.timing.clocks import ELSEWHERE_NS, SAME_CLOCK_NS, Clock, Clocks
from topic_scope.timing.lag import SETTLED_NS, Lag, median
from topic_scope.timing.nanoseconds import NO_TIME, NS

#: A stamp so far before those that came earlier is late, or its clock was set back [ns].
BACK_NS = NS // 2
#: A stamp further ahead than this is not believed unless others agree: it stands at reception [ns].
AHEAD_NS = 10 * NS
#: How many messages agree that a clock was set, and how long they take to come [ns]: a queue that
#: is emptied brings many late messages at once.
AGREE, AGREE_NS = 3, NS // 5
#: How long a message waits for others that agree with it [ns], or so many usual steps.
_PATIENCE_NS, _PATIENCE_STEPS = NS, 4
#: A simulation or a replay is no faster than this; and so many messages that contradict all before
#: them count, whatever they say.
_FASTEST, _STUBBORN = 20, 10
#: An estimate of the lag takes in at most so much of what was received at once [ns].
_PART_NS = NS


class Placed(NamedTuple):
    """Messages of a topic that follow one clock.

    :param clock: the clock
    :param times: when they were made, by that clock [ns]
    :param newest: the latest of these that is believed [ns]; what is older than that by more than
        samples are kept is forgotten
    :param moved: how far the times of earlier messages move by this clock [ns], so that they stay
        where they are shown, and their line ends; 0 where it goes on
    """

    clock: Clock
    times: numpy.ndarray
    newest: int
    moved: int


class Outliers(NamedTuple):
    """Stamps of a topic that others contradict.

    :param late: how many came after much later stamps
    :param latest: how late the worst was [ns]
    :param early: how many were ahead of the usual, and stand at their stamps
    :param refused: how many were too far away to be believed, and stand at reception
    :param furthest: how far ahead the worst of these was; below 0, behind [ns]
    """

    late: int = 0
    latest: int = 0
    early: int = 0
    refused: int = 0
    furthest: int = 0

    @property
    def text(self) -> str:
        """Their counts in words; empty without any."""
        words = []
        if self.late:
            words.append(f"{_count(self.late)} up to {self.latest / NS:.2f} s late")
        if self.early:
            words.append(f"{_count(self.early)} early")
        if self.refused:
            side = "ahead" if self.furthest > 0 else "behind"
            far = f"up to {abs(self.furthest) / NS:.6g} s {side}"
            words.append(f"{_count(self.refused)} {far}: shown at reception")
        return "; ".join(words)


class TopicTime:
    """Places the messages of a topic in time.

    :param clocks: those of all topics
    :param is_stamp: whether messages have stamps; else numbers with a zero of their own
    :param is_exact: whether stamps that count from the epoch keep their times

    :ivar clock: the clock that the stamps follow
    :ivar has_stamps: whether any message had one; else the time of receipt counts
    :ivar outliers: what was contradicted by others
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

    @property
    def patience(self) -> int:
        """Time that messages wait for others which agree with them, before they are final [ns]."""
        return max(_PATIENCE_NS, _PATIENCE_STEPS * self._step)

    def place(
        self, own: numpy.ndarray, received: numpy.ndarray, is_final: bool = False
    ) -> List[Placed]:
        """Place messages in time.

        :param own: their stamps [ns], or NO_TIME
        :param received: when they were received, ascending [ns]
        :param is_final: whether they do not wait for others
        :returns: their times in parts. Messages at the end that are in none wait for others, and
            belong before those of the next call
        """
        placed: List[Placed] = []
        start = stop = 0
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
        """Return whether all stamps are in order and as expected: most are, and need no more."""
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
        """Return how far behind their reception stamps are at least [ns].

        By the scope's own clock a stamp is not early where it is less late than others.
        """
        usual = self._lag.expected_of(received)
        return numpy.minimum(usual, 0) if self.clock.is_scope else usual

    def _contradicted(
        self, own: numpy.ndarray, received: numpy.ndarray
    ) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """Return which stamps contradict those before, and which are just early."""
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
        """Return how many messages agree that their clock was set; 0 where they do not.

        :param is_last: whether none will follow them
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
        span = int(received[there[-1]] - received[there[0]])
        apart = received[there] - own[there]
        is_steady = int(apart.max() - apart.min()) <= BACK_NS + _FASTEST * span
        rises = own[there[-1]] >= own[there[0]]
        agrees = (is_steady and rises) or self._alone >= _STUBBORN
        return int(there[-1]) + 1 if agrees else 0

    def _attach_first(self, own: numpy.ndarray, received: numpy.ndarray) -> None:
        there = own != NO_TIME
        if there.any():
            self.has_stamps = True
            self._attach(own[there], received[there])
            if self._is_exact and self.clock.is_scope and self._lag.usual < -AHEAD_NS:
                self._lag.begin(0, int(received[0]))  # to be believed only where others agree

    def _attach(
        self, own: numpy.ndarray, received: numpy.ndarray, left: Optional[Clock] = None
    ) -> None:
        """Follow the clock that some stamps fit.

        :param left: the clock that they do not follow any more
        """
        before = self.clock.offset
        self.clock.members.discard(self._lag)
        self.clock = self._clocks.find(own, received, self._is_stamp, self._is_exact, left)
        self._attached_at = median(received - own)
        self._lag.begin(self._attached_at, int(received[-1]))
        self.clock.members.add(self._lag)
        self._moved = before - self.clock.offset
        self._clocks.changes += 1

    def _jump(self, own: numpy.ndarray, received: numpy.ndarray) -> None:
        """Follow another clock, or the same one where it was set."""
        there = own != NO_TIME
        self.clock.members.discard(self._lag)
        self._lag, self._newest = Lag(), NO_TIME
        self._attach(own[there], received[there], None if self.clock.is_scope else self.clock)

    def _accepted(
        self,
        own: numpy.ndarray,
        received: numpy.ndarray,
        early: int,
        is_early: Optional[numpy.ndarray] = None,
    ) -> Placed:
        """Place messages at their stamps, or at reception where they have none.

        :param early: how many are ahead of the usual
        :param is_early: which are, if any
        """
        self._alone = 0
        moved, self._moved = self._moved, 0
        if not self.has_stamps:
            return Placed(self.clock, received, int(received[-1]), 0)
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
        return Placed(self.clock, times, self._newest, moved)

    def _learn(self, stamps: numpy.ndarray, received: numpy.ndarray) -> None:
        """Take messages into account for what is usual."""
        lag = self._lag
        self._step = (int(received[-1]) - (lag.received or int(received[0]))) // len(stamps)
        was_settled = lag.is_settled
        has_changed = lag.add(received, received - stamps)
        # Others of its clock that kept it where it was may be silent by now.
        if not has_changed and abs(lag.usual - self.clock.offset) <= SETTLED_NS:
            return
        if lag.is_settled and not was_settled and not lag.drift:
            if abs(lag.usual - self._attached_at) > SAME_CLOCK_NS:
                # The first messages were no example of the others.
                self._attach(stamps, received)
                self._moved = 0
        self._clocks.follow(self.clock, lag.received)

    def _placed_alone(self, own: numpy.ndarray, received: numpy.ndarray) -> Placed:
        """Place messages that no others agree with: at their stamps, if these can be believed."""
        self._alone += len(own)
        there = own != NO_TIME
        ahead = own - received + self._expected(received)
        is_refused = there & ((ahead > AHEAD_NS) | (ahead < -ELSEWHERE_NS))
        is_late = there & ~is_refused
        before = self.outliers
        refused = ahead[is_refused]
        furthest = [before.furthest, *refused.tolist()]
        late = int((-ahead[is_late]).max(initial=0))
        self.outliers = before._replace(
            late=before.late + int(is_late.sum()),
            latest=max(before.latest, late),
            refused=before.refused + len(refused),
            furthest=max(furthest, key=abs),
        )
        times = numpy.where(is_late, own, received - self.clock.offset)
        return Placed(self.clock, times, self._newest, 0)


def _leading(truths: numpy.ndarray) -> int:
    """Return how many truth values at the begin are true."""
    others = (~truths).nonzero()[0]
    return int(others[0]) if len(others) else len(truths)


def _count(number: int) -> str:
    return f"{number} stamp" if number == 1 else f"{number} stamps"
