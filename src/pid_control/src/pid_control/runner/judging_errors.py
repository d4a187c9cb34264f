"""Errors that prevent a judgement: invalid input, a busy machine, or the end of the time limit."""


class JudgingError(Exception):
    """Error of a controller that cannot be judged; the text gives the reason."""


class BusyMachineError(JudgingError):
    """Error of a machine that is too busy for a judgement."""


class TimeLimitExceeded(Exception):
    """Error of a judgement that exceeds its time limit."""
