"""What came of a scenario."""

from typing import List, NamedTuple, Optional, Sequence, Tuple

from pid_control.judging.scenarios import Scenario

#: What ended a scenario before its time. ENDED: the controller ended by itself. NOT_CONNECTED: it
#: did not find its topics. SILENT: it sends nothing any more, or never did. RESTLESS: it never had
#: nothing to do. WRITES_WITHOUT_END: its log grew.
ENDED, NOT_CONNECTED, SILENT = "ended", "not connected", "silent"
RESTLESS, WRITES_WITHOUT_END = "restless", "writes without end"
#: How long before the end of a scenario the last answer may be, s.
_SILENT_S = 0.5


class Row(NamedTuple):
    """A moment.

    :ivar time: s
    :ivar set_point: what was asked for, rad/s
    :ivar speed: what the motor really did, rad/s
    :ivar input: the motor's input; of what was sent the latest that is a number
    """

    time: float
    set_point: float
    speed: float
    input: float


class Record(NamedTuple):
    """What came of a scenario.

    :ivar scenario: the scenario
    :ivar failure: what ended it before its time, or nothing
    :ivar words: the last line that the controller wrote, where it has a failure
    :ivar missing: the topics that it did not find
    :ivar hint: what it does instead
    :ivar rows: all moments
    :ivar answers: the time of each message, s, and its input, whatever that is
    :ivar busy: processor time that the controller took, s
    :ivar standstill_answers: how many messages came while the clock stood still
    :ivar standstill_rest: share of that time in which the controller did nothing; None where the
        clock did not stand still
    """

    scenario: Scenario
    failure: str = ""
    words: str = ""
    missing: Sequence[str] = ()
    hint: str = ""
    rows: Sequence[Row] = ()
    answers: Sequence[Tuple[float, float]] = ()
    busy: float = 0.0
    standstill_answers: int = 0
    standstill_rest: Optional[float] = None

    @property
    def is_silent(self) -> bool:
        """Whether there was no answer any more for long before the end."""
        latest = self.answers[-1][0] if self.answers else 0.0
        return self.scenario.duration - latest > _SILENT_S

    def between(self, begin: float, end: float) -> List[Row]:
        """Return the moments from one time to another, s, without the latter."""
        return [row for row in self.rows if begin <= row.time < end]
