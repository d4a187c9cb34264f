"""Vectorised responses of many first-order plants with dead time, dead zone, limit and friction.

With input u, output y, gain K, time constant T, dead time L, dead zone m, limit w_max, offset c and
friction f::

    y = c + w,   T dw/dt + w = K z(t - L) - |K| f sign(w),   |w| <= w_max
    z = u where |u| > m, else 0

At w = 0 the plant rests while ``|z| <= f`` (Coulomb friction; Olsson et al.: Friction models and
friction compensation, European Journal of Control 4, 1998). The input is held from one change to
the next, so y is known in closed form, as in :mod:`first_order_sys_sim.first_order_plant`.
"""

import math
from typing import NamedTuple

import numpy

from pid_control.identification.record import Record

#: Columns of an array of candidates.
GAIN, TIME_CONSTANT, DEAD_TIME, START, DEAD_ZONE, LIMIT, OFFSET, FRICTION = range(8)
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
    :ivar limit: w_max, largest magnitude of the output without its offset
    :ivar offset: c, output to which the plant returns without an input
    :ivar friction: f, part of the input that Coulomb friction takes
    """

    gain: float
    time_constant: float
    dead_time: float = 0.0
    dead_zone: float = 0.0
    limit: float = math.inf
    offset: float = 0.0
    friction: float = 0.0


def responses(record: Record, candidates: numpy.ndarray) -> numpy.ndarray:
    """Return the responses of plants to the input of a record.

    :param record: supplies the inputs and the times of the outputs
    :param candidates: one row per plant: GAIN, TIME_CONSTANT, DEAD_TIME, START (the output
        until the record's first input acts), DEAD_ZONE, LIMIT, OFFSET and FRICTION
    :returns: one row per plant, with one output per time of the record
    """
    numbers = len(candidates) * max(len(record.inputs), len(record.times))
    parts = numpy.array_split(candidates, min(-(-numbers // _TOGETHER), len(candidates)))
    return numpy.concatenate([_responses(record, part) for part in parts])


def _responses(record: Record, candidates: numpy.ndarray) -> numpy.ndarray:
    gain, tau, delay, start, zone, limit, offset, friction = (
        column[:, None] for column in candidates.T
    )
    limit = numpy.minimum(limit, _UNLIMITED)
    brake = numpy.abs(gain) * friction
    targets = gain * numpy.where(numpy.abs(record.inputs) > zone, record.inputs, 0.0)
    decays = numpy.exp(-numpy.diff(record.changed_at) / tau)
    first = _limited(start - offset, -limit, limit)
    if brake.any():
        states = _braked_states(targets - brake, targets + brake, decays, first, limit)
    else:
        states = _states(targets, decays, first, limit)
    due = record.times - delay
    held = numpy.maximum(numpy.searchsorted(record.changed_at, due, side="right") - 1, 0)
    elapsed = numpy.maximum(due - record.changed_at[held], 0.0)
    target = numpy.take_along_axis(targets, held, axis=1)
    state = numpy.take_along_axis(states, held, axis=1)
    decay = numpy.exp(-elapsed / tau)
    if brake.any():
        free = _braked(state, target - brake, target + brake, decay)
    else:
        free = target + (state - target) * decay
    return offset + _limited(free, -limit, limit)


def _braked(
    state: numpy.ndarray, above: numpy.ndarray, below: numpy.ndarray, decay: numpy.ndarray
) -> numpy.ndarray:
    """Return the states of plants with friction, after their input was held for a time.

    :param state: w at the beginning
    :param above: w that the input would reach if w stayed above 0: the target less the friction
    :param below: the same below 0: the target plus the friction
    :param decay: exp(-time / T)
    """
    is_above = state > 0.0
    ahead = numpy.where(is_above, above, below)
    moved = ahead + (state - ahead) * decay
    # Beyond 0 the friction changes its sign: the same share remains, of the distance to the state
    # that the input reaches there; no distance if the friction holds the plant at 0.
    beyond = numpy.where(is_above, numpy.minimum(below, 0.0), numpy.maximum(above, 0.0))
    passed = beyond * moved / numpy.where(ahead == 0.0, 1.0, ahead)
    braked: numpy.ndarray = numpy.where((moved > 0.0) == is_above, moved, passed)
    return braked


def _braked_states(
    above: numpy.ndarray,
    below: numpy.ndarray,
    decays: numpy.ndarray,
    first: numpy.ndarray,
    limit: numpy.ndarray,
) -> numpy.ndarray:
    """Return the outputs at the changes of the input, one after the other.

    As :func:`_braked`, with single numbers: for a few plants, arrays take ten times as long.
    """
    states = numpy.empty_like(above)
    for row, most in enumerate(limit[:, 0].tolist()):
        state = first[row, 0].item()
        found = [state]
        for over, under, decay in zip(
            above[row].tolist(), below[row].tolist(), decays[row].tolist()
        ):
            ahead = over if state > 0.0 else under
            moved = ahead + (state - ahead) * decay
            if state > 0.0 >= moved:
                moved *= min(under, 0.0) / (ahead or 1.0)
            elif state <= 0.0 < moved:
                moved *= max(over, 0.0) / ahead
            state = min(max(moved, -most), most)
            found.append(state)
        states[row] = found
    return states


def _states(
    targets: numpy.ndarray, decays: numpy.ndarray, first: numpy.ndarray, limit: numpy.ndarray
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
            model.offset,
            model.friction,
        ]
    )
