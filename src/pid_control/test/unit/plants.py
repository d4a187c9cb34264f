"""Random plants and their records."""

import math
import random

import numpy
from scipy.signal import lfilter

from pid_control.identification.excitation import excitation
from pid_control.identification.fit import identify
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


def autocorrelated(record: Record, noise: float, alike: float, seed: int) -> Record:
    """Return a record with AR(1) noise.

    :param noise: standard deviation, as a share of the outputs' range
    :param alike: correlation of neighbouring outputs, from 0 to below 1
    """
    draws = numpy.random.RandomState(seed).normal(0.0, 1.0, len(record.times))
    draws[1:] *= math.sqrt(1.0 - alike**2)
    noises = lfilter([1.0], [1.0, -alike], draws)
    return record._replace(outputs=record.outputs + noise * record.span * noises)


def errors_of(model: Model, found: Model) -> numpy.ndarray:
    """Return how wrong the first five values are, as a share; the dead time as one of it and T."""
    scales = numpy.abs(model[:5])
    scales[2] += model.time_constant
    errors: numpy.ndarray = numpy.abs(numpy.subtract(found[:5], model[:5])) / scales
    return errors


def check_random_plants(count: int, noise: float, most: float, covered: float) -> None:
    """Identify plants at random from their records, and check each value of each.

    :param count: how many plants
    :param noise: standard deviation, as a share of the outputs' range
    :param most: how wrong a value may be, as a share
    :param covered: the least share of plants within the stated uncertainty; without noise a value
        is exact instead
    """
    worst, inside = numpy.zeros(5), numpy.zeros(5)
    for seed in range(count):
        model = plant(seed)
        found = identify(recorded(model, noise, seed, 3500 if noise else 1000))
        errors = errors_of(model, found.model)
        assert errors.max() <= most, (seed, model, found.model)
        worst = numpy.maximum(worst, errors)
        assert (found.model.offset, found.model.friction) == (0.0, 0.0), (seed, found.model)
        inside += numpy.abs(numpy.subtract(found.model, model))[:5] <= found.uncertainty[:5]
    if noise:
        assert inside.min() >= covered * count, inside
    else:
        assert worst[[0, 1, 2, 4]].max() < 1e-5, worst
