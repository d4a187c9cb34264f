"""Plants at random, and what is recorded of them."""

import math
import random

import numpy

from pid_control.identification.excitation import excitation
from pid_control.identification.record import Record, record_of
from pid_control.identification.response import Model, candidate, responses


def plant(seed: int) -> Model:
    """Return a plant that meets its limit; of any gain, fast or slow."""
    numbers = random.Random(seed)
    gain = numbers.choice([-1.0, 1.0]) * math.exp(numbers.uniform(-3.0, 4.0))
    tau = math.exp(numbers.uniform(math.log(0.02), math.log(2.0)))
    limit = abs(gain) * numbers.uniform(0.4, 0.9)
    return Model(gain, tau, numbers.uniform(0.0, 1.0) * tau, numbers.uniform(0.1, 0.3), limit)


def recorded(model: Model, noise: float = 0.0, seed: int = 0, outputs: int = 2000) -> Record:
    """Return the record of an experiment of a hundred time constants.

    :param noise: standard deviation, as a share of the outputs' range
    """
    duration = 100.0 * model.time_constant
    changes = excitation(-1.0, 1.0, duration)
    return answered([list(one) for one in changes], model, duration, noise, seed, outputs)


def answered(
    changes: list,
    model: Model,
    duration: float,
    noise: float = 0.0,
    seed: int = 0,
    outputs: int = 2000,
) -> Record:
    """Return the record of a plant that is given these inputs, each with its time."""
    given, inputs = numpy.array(changes, float).T
    times = numpy.linspace(0.0, duration, outputs)
    blank = record_of(given, inputs, times, times)
    values = responses(blank, candidate(model, 0.0)[None, :])[0]
    spread = noise * numpy.ptp(values)
    values = values + numpy.random.RandomState(seed).normal(0.0, 1.0, len(values)) * spread
    return record_of(given, inputs, times, values)
