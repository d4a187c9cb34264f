"""Waveforms as pure functions from phase (or time) to a value in [-1, 1].

The periodic shapes take a phase in rad and repeat every 2 pi. A shape with a jump counts a sample
within :data:`EDGE` before the jump as after it: sample times are rounded, so a sample exactly on an
edge could otherwise fall on either side of it.
"""

import math

TWO_PI = 2.0 * math.pi

#: A sample this close before a jump already counts as after it, relative to the period.
EDGE = 1e-9


def cycle_fraction(phase: float) -> float:
    """Return how much of the current period has passed.

    :param phase: phase [rad]
    :returns: part of the period, in [0, 1)
    """
    fraction = phase / TWO_PI % 1.0
    return fraction if fraction < 1.0 - EDGE else 0.0


def sine(phase: float) -> float:
    """Return the sine of a phase.

    :param phase: phase [rad]
    :returns: value in [-1, 1]
    """
    return math.sin(phase)


def square(phase: float, duty: float = 0.5) -> float:
    """Return a square wave: high from phase 0 for the duty part of the period, then low.

    :param phase: phase [rad]
    :param duty: high part of the period, in (0, 1)
    :returns: 1 or -1
    """
    return 1.0 if cycle_fraction(phase) + EDGE < duty else -1.0


def pulse(phase: float, duty: float = 0.5) -> float:
    """Return a pulse train: as :func:`square`, but at rest at zero.

    :param phase: phase [rad]
    :param duty: high part of the period, in (0, 1)
    :returns: 1 or 0
    """
    return 1.0 if cycle_fraction(phase) + EDGE < duty else 0.0


def triangle(phase: float) -> float:
    """Return a symmetric triangle with the zeros and the peaks of the sine.

    :param phase: phase [rad]
    :returns: value in [-1, 1]; 0 and rising at phase 0
    """
    quarters = 4.0 * cycle_fraction(phase)
    if quarters < 1.0:
        return quarters
    return 2.0 - quarters if quarters < 3.0 else quarters - 4.0


def sawtooth(phase: float, symmetry: float = 1.0) -> float:
    """Return a sawtooth: up from -1 to 1 in the symmetry part of the period, then down again.

    The convention is that of ``scipy.signal.sawtooth``, whose ``width`` is the symmetry here.

    :param phase: phase [rad]
    :param symmetry: rising part of the period, in [0, 1]; 0.5 is a triangle that starts at -1
    :returns: value in [-1, 1]
    """
    fraction = cycle_fraction(phase)
    if fraction < symmetry:
        return 2.0 * fraction / symmetry - 1.0
    return 1.0 - 2.0 * (fraction - symmetry) / (1.0 - symmetry)


def step(time: float, step_time: float) -> float:
    """Return a unit step.

    :param time: time [s]
    :param step_time: time of the step [s]
    :returns: 0 before the step, 1 from the step on
    """
    return 0.0 if time < step_time else 1.0


def ramp(time: float, slope: float, limit: float) -> float:
    """Return a ramp from zero that stops at a limit, as a part of that limit.

    :param time: time since the start of the ramp [s]
    :param slope: gradient [1/s]
    :param limit: peak, >= 0
    :returns: value in [-1, 1]
    """
    value = slope * time
    if abs(value) >= limit:
        return math.copysign(1.0, value) if value else 0.0
    return value / limit
