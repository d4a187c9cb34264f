"""Pure functions from phase to value."""

import math


def sine(phase: float) -> float:
    """Return the sine of a phase.

    :param phase: phase, rad
    :returns: value in [-1, 1]
    """
    return math.sin(phase)
