"""Parameters of the set point generator node: those of a signal generator."""

from typing import Any

from basic_comms.signals.signal_parameters import SignalParameters


class SetPointParameters(SignalParameters):
    """Parameters of the set point generator: a signal generator's, without ``autostart``."""

    #: Constant instead of a parameter: a set point has no service that enables it.
    autostart: Any = property(lambda self: True)
