"""The response of first-order plants with dead time, dead zone and limit; many of them at once.

With input u, output y, gain K, time constant T, dead time L, dead zone m and limit y_max::

    T dy/dt + y = K z(t - L),   z = u where |u| > m, else 0,   |y| <= y_max

The input is held from one change to the next, so y is known in closed form, as in
:mod:`first_order_sys_sim.first_order_plant`, of which this is the same law, written for arrays.
"""

import math
from typing import NamedTuple

import numpy

from pid_control.identification.record import Record

#: The columns of an array of candidates.
GAIN, TIME_CONSTANT, DEAD_TIME, START, DEAD_ZONE, LIMIT = range(6)
#: A limit that is never met, but times 0 is no NaN.
_UNLIMITED = 1e300
#: As many numbers are worked on at once: more would only fill the memory.
_TOGETHER = 50_000


class Model(NamedTuple):
    """What a plant is like.

    :ivar gain: K, output for each unit of input
    :ivar time_constant: T, s
    :ivar dead_time: L, s
    :ivar dead_zone: m, magnitude up to which an input acts as 0
    :ivar limit: y_max, largest magnitude of the output
    """

    gain: float
    time_constant: float
    dead_time: float = 0.0
    dead_zone: float = 0.0
    limit: float = math.inf


def responses(record: Record, candidates: numpy.ndarray) -> numpy.ndarray:
    """Return what plants would have answered to the input of a record.

    :param record: its inputs, and the times of its outputs
    :param candidates: a row for each plant: GAIN, TIME_CONSTANT, DEAD_TIME, START (the output
        until the record's first input arrives), DEAD_ZONE and LIMIT
    :returns: a row for each plant, with an output for each time of the record
    """
    numbers = len(candidates) * max(len(record.inputs), len(record.times))
    parts = numpy.array_split(candidates, min(-(-numbers // _TOGETHER), len(candidates)))
    return numpy.concatenate([_responses(record, part) for part in parts])


def _responses(record: Record, candidates: numpy.ndarray) -> numpy.ndarray:
    gain, tau, delay, start, zone, limit = (column[:, None] for column in candidates.T)
    limit = numpy.minimum(limit, _UNLIMITED)
    targets = gain * numpy.where(numpy.abs(record.inputs) > zone, record.inputs, 0.0)
    states = _states(targets, numpy.exp(-numpy.diff(record.changed_at) / tau), start, limit)
    due = record.times - delay
    held = numpy.maximum(numpy.searchsorted(record.changed_at, due, side="right") - 1, 0)
    elapsed = numpy.maximum(due - record.changed_at[held], 0.0)
    target = numpy.take_along_axis(targets, held, axis=1)
    state = numpy.take_along_axis(states, held, axis=1)
    return _limited(target + (state - target) * numpy.exp(-elapsed / tau), -limit, limit)


def _states(
    targets: numpy.ndarray, decays: numpy.ndarray, start: numpy.ndarray, limit: numpy.ndarray
) -> numpy.ndarray:
    """Return the outputs at the changes of the input, of which each follows from the last one.

    From one to the next the output y becomes clip(a y + b, low, high); and so it does over two of
    them, with other numbers, over four, and so on (a prefix sum; Hillis, Steele: Data parallel
    algorithms, CACM 29, 1986). That takes ten passes over arrays in place of a thousand turns.
    """
    a = decays.copy()
    b = targets[:, :-1] * (1.0 - decays)
    high = numpy.broadcast_to(limit, b.shape).copy()
    low = -high
    reach = 1
    while reach < b.shape[1]:
        by, plus, least, most = a[:, reach:], b[:, reach:], low[:, reach:], high[:, reach:]
        new_low = _limited(by * low[:, :-reach] + plus, least, most)
        new_high = _limited(by * high[:, :-reach] + plus, least, most)
        b[:, reach:] = by * b[:, :-reach] + plus
        a[:, reach:] = by * a[:, :-reach]
        low[:, reach:], high[:, reach:] = new_low, new_high
        reach *= 2
    first = _limited(start, -limit, limit)
    return numpy.hstack([first, _limited(a * first + b, low, high)])


def _limited(values: numpy.ndarray, low: numpy.ndarray, high: numpy.ndarray) -> numpy.ndarray:
    """Do what numpy.clip does, in a third of its time."""
    limited: numpy.ndarray = numpy.minimum(numpy.maximum(values, low), high)
    return limited


def candidate(model: Model, start: float) -> numpy.ndarray:
    """Return a model as a row of candidates.

    :param model: the plant
    :param start: its output at first
    """
    return numpy.array(
        [
            model.gain,
            model.time_constant,
            model.dead_time,
            start,
            model.dead_zone,
            model.limit,
        ]
    )
