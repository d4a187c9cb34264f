"""The parameters of the set point: those of a signal."""

from typing import Any

from basic_comms.signals.signal_parameters import SignalParameters


class SetPointParameters(SignalParameters):
    """All that a signal can be."""

    #: It starts by itself, as there is nothing to enable it; no parameter any more.
    autostart: Any = property(lambda self: True)
