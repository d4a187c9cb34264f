"""Outcomes of a scenario, with any plant."""

from typing import Protocol

from pid_control.judging.record import ENDED, RESTLESS, SILENT, WRITES_WITHOUT_END, Record
from pid_control.judging.scenarios import Scenario
from pid_control.runner.controller_process import ControllerProcess

#: Consecutive steps without an idle controller that make it restless.
_RESTLESS_STEPS = 2


class JudgingError(Exception):
    """The controller cannot be judged; the message says why."""


class TimeLimitExceeded(Exception):
    """The judgement exceeds its time limit."""


class Runner(Protocol):
    """Runner of scenarios.

    :ivar most_late: largest allowed delay of the judge with the machine's clock [s]
    :ivar latest: largest delay so far [s]
    """

    most_late: float
    latest: float

    def run(self, scenario: Scenario) -> Record:
        """Run one scenario.

        :raises TimeLimitExceeded: if the deadline has passed
        :raises OSError: if the controller cannot be started
        """


def failure_of(controller: ControllerProcess, restless: int = 0) -> str:
    """Return the failure of a controller, empty if none.

    :param controller: the controller
    :param restless: number of consecutive steps without an idle controller
    """
    if controller.status is not None:
        return ENDED
    if controller.writes_without_end:
        return WRITES_WITHOUT_END
    return RESTLESS if restless >= _RESTLESS_STEPS else ""


def completed(record: Record, controller: ControllerProcess) -> Record:
    """Return a record with SILENT set if it applies, and the last output line for a failure.

    :param record: record of the scenario
    :param controller: the controller
    """
    if not record.failure and record.is_silent:
        record = record._replace(failure=SILENT)
    return record._replace(words=controller.last_words() if record.failure else "")
