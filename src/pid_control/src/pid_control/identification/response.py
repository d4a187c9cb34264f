"""Responses of many first-order plants with dead time, dead zone and limit, vectorised.

With input u, output y, gain K, time constant T, dead time L, dead zone m and limit y_max::

    T dy/dt + y = K z(t - L),   z = u where |u| > m, else 0,   |y| <= y_max

The input is held from one change to the next, so y is known in closed form, as in
:mod:`first_order_sys_sim.first_order_plant`; this is the same equation for arrays.
"""

import math
from typing import NamedTuple

import numpy

from pid_control.identification.record import Record

#: Columns of an array of candidates.
GAIN, TIME_CONSTANT, DEAD_TIME, START, DEAD_ZONE, LIMIT = range(6)
#: A limit that is never reached; finite, because infinity times 0 is NaN.
_UNLIMITED = 1e300
#: Largest number of array elements processed at once, to bound the memory.
_TOGETHER = 50_000


class Model(NamedTuple):
    """Parameters of a first-order plant.

    :ivar gain: K, output per unit of input
    :ivar time_constant: T [s]
    :ivar dead_time: L [s]
    :ivar dead_zone: m, magnitude up to which an input acts as 0
    :ivar limit: y_max, largest magnitude of the output
    """

    gain: float
    time_constant: float
    dead_time: float = 0.0
    dead_zone: float = 0.0
    limit: float = math.inf


def responses(record: Record, candidates: numpy.ndarray) -> numpy.ndarray:
    """Return the responses of plants to the input of a record.

    :param record: supplies the inputs and the times of the outputs
    :param candidates: one row per plant: GAIN, TIME_CONSTANT, DEAD_TIME, START (the output
        until the record's first input acts), DEAD_ZONE and LIMIT
    :returns: one row per plant, with one output per time of the record
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
    """Return the outputs at the changes of the input, computed as a parallel prefix sum.

    From one change to the next the output y becomes clip(a y + b, low, high); so it does over two
    changes, with other coefficients, over four, and so on (Hillis, Steele: Data parallel
    algorithms, CACM 29, 1986): ten passes over arrays instead of a loop over a thousand changes.
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
    """Clip values, three times as fast as numpy.clip."""
    limited: numpy.ndarray = numpy.minimum(numpy.maximum(values, low), high)
    return limited


def candidate(model: Model, start: float) -> numpy.ndarray:
    """Return a model as a row of an array of candidates.

    :param model: the plant
    :param start: its initial output
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
