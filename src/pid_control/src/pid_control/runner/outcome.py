"""How a run through a scenario may end, whatever plant it is with."""

from typing import Protocol

from pid_control.judging.record import ENDED, RESTLESS, SILENT, WRITES_WITHOUT_END, Record
from pid_control.judging.scenarios import Scenario
from pid_control.runner.controller_process import ControllerProcess

#: In how many steps on end a controller may come to no rest.
_RESTLESS_STEPS = 2


class JudgingError(Exception):
    """There is nothing to be judged; the text says why."""


class TimeLimitExceeded(Exception):
    """The judgement takes longer than it may."""


class Runner(Protocol):
    """Runs a controller through scenarios.

    :ivar most_late: how late the judge may be where it goes by the machine's clock, s
    :ivar latest: how late it was, s
    """

    most_late: float
    latest: float

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :raises TimeLimitExceeded: if all takes too long
        :raises OSError: if the controller cannot be started
        """


def failure_of(controller: ControllerProcess, restless: int = 0) -> str:
    """Return what has become of a controller, nothing while it is well.

    :param controller: the controller
    :param restless: in how many steps on end it came to no rest
    """
    if controller.status is not None:
        return ENDED
    if controller.writes_without_end:
        return WRITES_WITHOUT_END
    return RESTLESS if restless >= _RESTLESS_STEPS else ""


def completed(record: Record, controller: ControllerProcess) -> Record:
    """Return a record that tells a controller's silence, and its last words where it has a failure.

    :param record: what came of the scenario
    :param controller: the controller
    """
    if not record.failure and record.is_silent:
        record = record._replace(failure=SILENT)
    return record._replace(words=controller.last_words() if record.failure else "")
