"""Detection of failures of a controller in a scenario: ended, endless output, or never idle."""

import signal
import time
from typing import Callable, Optional

from pid_control.judging.record import ENDED, RESTLESS, SILENT, WRITES_WITHOUT_END, Record
from pid_control.programs.program_process import ProgramProcess
from pid_control.runner.judging_errors import BusyMachineError, JudgingError

#: A controller that never rests is restless above this processor time; with less, the machine is
#: too busy after this time [s].
_RESTLESS_S, _STARVED_S = 3.0, 30.0
#: Steps without a flood of messages after which a flood is over. A loop without a pause seems idle
#: at moments in between, while it waits for this process to take its messages.
_CALM_STEPS = 50
#: Exit status of a killed process, as by the kernel without free memory.
_KILLED = -signal.SIGKILL


class BusyDetector:
    """Detector of a controller that is never idle, or of a machine too busy to run it.

    :param processor_time: returns the controller's processor time so far [s]
    """

    def __init__(self, processor_time: Callable[[], float]) -> None:
        self._processor_time = processor_time
        self._since = 0.0
        #: Processor time when the controller was last idle; None if it is idle now.
        self._before: Optional[float] = None
        #: Steps that remain until the latest flood is over.
        self._flood_steps = 0

    def update(self, is_idle: bool, is_flood: bool = False) -> None:
        """Record the latest step.

        :param is_idle: whether the controller became idle in it
        :param is_flood: whether it sent more messages than a loop with a pause can
        """
        self._flood_steps = _CALM_STEPS if is_flood else max(self._flood_steps - 1, 0)
        if is_idle and not self._flood_steps:
            self._before = None
        elif self._before is None:
            self._since, self._before = time.monotonic(), self._processor_time()

    def is_its_own(self) -> bool:
        """Return True if the controller computes without a pause.

        :raises BusyMachineError: if it has waited too long for the machine
        """
        if self._before is None:
            return False
        if self._processor_time() - self._before > _RESTLESS_S:
            return True
        if time.monotonic() - self._since > _STARVED_S:
            raise BusyMachineError(
                "this machine is too busy: the controller gets no processor time"
            )
        return False


def failure_of(controller: ProgramProcess, is_restless: bool = False) -> str:
    """Return the failure of a controller, empty if none.

    :param controller: the controller
    :param is_restless: whether it computes without a pause
    :raises JudgingError: if the machine ended it
    """
    if controller.status == _KILLED:
        raise JudgingError("the controller was killed (signal 9), maybe for lack of memory")
    if controller.status is not None:
        return ENDED
    if controller.writes_without_end:
        return WRITES_WITHOUT_END
    return RESTLESS if is_restless else ""


def completed(record: Record, controller: ProgramProcess) -> Record:
    """Return a record with SILENT set if it applies, and the last output line for a failure.

    :param record: record of the scenario
    :param controller: the controller
    """
    if not record.failure and record.is_silent:
        record = record._replace(failure=SILENT)
    return record._replace(words=controller.last_words() if record.failure else "")
