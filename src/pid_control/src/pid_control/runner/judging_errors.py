"""Errors that prevent a judgement: invalid input, a busy machine, or the end of the time limit."""


class JudgingError(Exception):
    """The controller cannot be judged; the message says why."""


class BusyMachineError(JudgingError):
    """The machine is too busy for a judgement."""


class TimeLimitExceeded(Exception):
    """The judgement exceeds its time limit."""
