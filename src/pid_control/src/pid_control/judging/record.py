"""Record of one run of a scenario: set point, speed and input over time, and any failure."""

from typing import List, NamedTuple, Sequence, Tuple

from pid_control.judging.scenarios import Scenario

#: Failures that end a scenario early. ENDED: the controller exited. NOT_CONNECTED: it did not
#: connect to its topics. SILENT: it sent nothing, or stopped sending. RESTLESS: it was never idle.
#: WRITES_WITHOUT_END: its log grew too long.
ENDED, NOT_CONNECTED, SILENT = "ended", "not connected", "silent"
RESTLESS, WRITES_WITHOUT_END = "restless", "writes without end"
#: Longest time without answers at the end of a scenario [s].
_SILENT_S = 0.5


class Row(NamedTuple):
    """State of the loop at one time.

    :ivar time: time in the scenario [s]
    :ivar set_point: set point [rad/s]
    :ivar speed: true speed of the motor [rad/s]
    :ivar input: the motor's input, the latest finite one
    """

    time: float
    set_point: float
    speed: float
    input: float


class Pause(NamedTuple):
    """Pause of the clock.

    :ivar time: time in the scenario [s]
    :ivar length: duration by the machine's clock [s]
    :ivar rest: share of it in which the controller was idle, apart from waits for a processor
    :ivar answers: number of answers in its second half; late answers arrive in the first
    """

    time: float
    length: float
    rest: float
    answers: int


class Record(NamedTuple):
    """Record of a scenario.

    :ivar scenario: the scenario
    :ivar failure: the failure that ended it early, or empty
    :ivar words: last line of the controller's output, for a failure
    :ivar missing: topics that the controller did not connect to
    :ivar hint: text about the topics that the controller publishes instead
    :ivar rows: state of the loop over time
    :ivar answers: time [s] and input of each message, finite or not
    :ivar busy: processor time of the controller [s]
    :ivar is_simulated: True if the clock was simulated
    :ivar pauses: pauses of the clock; empty with the machine's clock
    """

    scenario: Scenario
    failure: str = ""
    words: str = ""
    missing: Sequence[str] = ()
    hint: str = ""
    rows: Sequence[Row] = ()
    answers: Sequence[Tuple[float, float]] = ()
    busy: float = 0.0
    is_simulated: bool = False
    pauses: Sequence[Pause] = ()

    @property
    def is_silent(self) -> bool:
        """True if the last answers of the scenario are missing."""
        latest = self.answers[-1][0] if self.answers else 0.0
        return self.scenario.duration - latest > _SILENT_S

    def between(self, begin: float, end: float) -> List[Row]:
        """Return the rows from one time up to, and excluding, another [s]."""
        return [row for row in self.rows if begin <= row.time < end]
