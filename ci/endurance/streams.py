"""What a stream of samples tells: what is missing in it, and how long it was silent."""

from typing import Optional, Sequence

#: from here on a silence is counted as a gap, s; a stalled subscriber may cost that much, once
GAP = 0.05


class Arrivals:
    """Figures of a stream, kept up message by message in constant memory."""

    def __init__(self) -> None:
        self.count = 0
        #: moment of the latest message, s
        self.latest: Optional[float] = None
        #: longest silence, s
        self.longest_gap = 0.0
        #: how many silences were longer than GAP
        self.gaps = 0

    def add(self, moment: float, messages: int = 1) -> None:
        """Take in messages that came together.

        :param moment: when, on a monotonic clock, s
        """
        if self.latest is not None:
            self.note_silence(moment)
        self.latest = moment
        self.count += messages

    def note_silence(self, now: float) -> None:
        """Count a silence that has lasted until now."""
        if self.latest is not None:
            gap = now - self.latest
            self.longest_gap = max(self.longest_gap, gap)
            self.gaps += gap > GAP


class Continuity:
    """Counts the samples that are missing between the first and the last one.

    :param period: from one sample to the next, s
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._latest: Optional[float] = None
        self.missing = 0
        #: in how many places something is missing, and how much at most in one
        self.holes = 0
        self.largest_hole = 0
        #: samples whose time is that of the one before, or earlier
        self.repeated = 0

    def add(self, time_x: float) -> None:
        """Take in the next sample.

        :param time_x: its own time, s
        """
        if self._latest is not None:
            steps = round((time_x - self._latest) / self._period)
            if steps < 1:
                self.repeated += 1
            elif steps > 1:
                self.missing += steps - 1
                self.holes += 1
                self.largest_hole = max(self.largest_hole, steps - 1)
        self._latest = time_x


def shift(expected: Sequence[float], answers: Sequence[float], furthest: int) -> int:
    """Return by how many places answers must be moved on to lie on what is expected.

    :param expected: a value for each sample
    :param answers: a part of the answers, fewer than the samples
    :param furthest: how many places to try, from 0 on
    :returns: the place of the first answer among the expected ones
    :raises ValueError: if the answers lie nowhere on them
    """
    last = min(furthest, len(expected) - len(answers)) if answers else -1
    errors = {
        place: max(abs(a - e) for a, e in zip(answers, expected[place:]))
        for place in range(last + 1)
    }
    best = min(errors, key=lambda place: errors[place], default=0)
    if not errors or errors[best] > 1e-4:
        raise ValueError("the answers do not belong to these samples")
    return best


def unanswered(expected: Sequence[float], answers: Sequence[float], window: int = 400) -> int:
    """Return how many samples have no answer, between the first answered one and the last one.

    The answers come in the order of the samples, so that each missing one moves those after it.

    :param expected: the answer to each sample
    :param answers: those that came; either list may begin and end before the other
    :param window: how far apart the lists may begin
    """
    # The list that begins later lies somewhere on the other one.
    begin = _offset(expected[: 3 * window], answers[: 3 * window], window)
    end = _offset(expected[::-1][: 3 * window], answers[::-1][: 3 * window], window)
    samples = len(expected) - max(begin, 0) - max(end, 0)
    answered = len(answers) - max(-begin, 0) - max(-end, 0)
    return samples - answered


def _offset(expected: Sequence[float], answers: Sequence[float], window: int) -> int:
    try:
        return shift(expected, answers[:window], window)
    except ValueError:
        return -shift(answers, expected[:window], window)
