"""The parameters of the set point: those of a signal, under the names that the course gave them."""

import copy
from typing import Any

from basic_comms.signals.signal_parameters import SignalParameters


def _with_default(name: str, default: float) -> Any:
    """Return a signal's parameter with another default, to be declared under another name."""
    parameter = copy.copy(SignalParameters.declared[name])
    parameter.default = default
    return parameter


class SetPointParameters(SignalParameters):
    """All that a signal can be, with ``omega`` in the place of ``frequency``."""

    omega = _with_default("frequency", 1.0)
    #: What the signal source reads; no parameter any more.
    frequency: Any = property(lambda self: self.omega)
    #: The motor decides when the signal starts.
    autostart: Any = False
