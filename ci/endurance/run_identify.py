"""Identify 15 plants from many records each, and count how often each ± holds."""

import math
from concurrent.futures import ProcessPoolExecutor
from typing import Dict, Iterable, List, NamedTuple, Tuple

import numpy
from scipy.signal import lfilter

from pid_control.identification.excitation import excitation
from pid_control.identification.fit import identify
from pid_control.identification.record import IdentificationError, record_of
from pid_control.identification.response import Model, candidate, responses

from .checks import Check, at_most, reported
from .context import Soak

#: Bounds of the share within ± [%], which is to be 95.
LEAST, MOST = 90.0, 99.0
#: Outputs of a record; its duration [T]; the noise, as a share of the outputs' range.
OUTPUTS, DURATION, NOISE = 1500, 100.0, 0.02
#: How many times as many records decide about a plant that is out of bounds.
MORE = 4
#: Correlations of neighbouring outputs' noise.
ALIKE = (0.0, 0.5, 0.9)
PLANTS = (
    Model(10.0, 0.3, 0.05),
    Model(13.1, 0.04, 0.01, 0.1, 9.0),
    Model(50.0, 2.0, 0.4, offset=20.0),
    Model(-4.0, 0.5, 0.1, friction=0.15),
    Model(2.0, 1.0, 0.2, 0.2, offset=-1.0),
)


class Draw(NamedTuple):
    """One record of a plant: index in PLANTS, noise, and seed."""

    plant: int
    alike: float
    seed: int


class Outcome(NamedTuple):
    """Whether each value is within its ±; the wrong terms; whether ± was withdrawn."""

    draw: Draw
    inside: Dict[str, bool]
    wrong_terms: List[str]
    is_withdrawn: bool


def run(soak: Soak) -> List[Check]:
    """Identify each plant with each noise, twice as often as --times.

    Values of one record are alike, so that of a hundred records 89 % may be within ± where 94 % of
    all are. A plant that is out of bounds is identified from more records, which count with them.
    """
    first = range(soak.seed, soak.seed + 2 * soak.times)
    more = range(first.stop, first.stop + MORE * len(first))
    draws = [
        Draw(plant, alike, seed)
        for plant in range(len(PLANTS))
        for alike in ALIKE
        for seed in first
    ]
    with ProcessPoolExecutor() as pool:
        outcomes = list(pool.map(identify_one, draws, chunksize=5))
        by_plant = _by_plant(outcomes)
        unclear = [plant for plant, inside in by_plant.items() if not _is_kept(inside)]
        others = [Draw(*plant, seed) for plant in unclear for seed in more]
        further = _by_plant(pool.map(identify_one, others, chunksize=5))
    shares: Dict[str, List[bool]] = {}
    for outcome in outcomes:
        for name, is_inside in outcome.inside.items():
            shares.setdefault(f"{name} within ±", []).append(is_inside)
    for (plant, alike), inside in by_plant.items():
        name = f"plant {plant + 1}, noise correlated by {alike:g}: values within ±"
        shares[name] = inside + further.get((plant, alike), [])
    wrong = [f"{outcome.draw}: {term}" for outcome in outcomes for term in outcome.wrong_terms]
    withdrawn = sum(outcome.is_withdrawn for outcome in outcomes)
    return [
        *(_between(what, inside) for what, inside in sorted(shares.items())),
        reported("first of the wrong terms", "; ".join(wrong[:3]) or "none"),
        at_most("records with a wrong term", 100.0 * len(wrong) / len(draws), 2.0, "%"),
        at_most("records whose ± is withdrawn", 100.0 * withdrawn / len(draws), 2.0, "%"),
    ]


def _by_plant(outcomes: Iterable[Outcome]) -> Dict[Tuple[int, float], List[bool]]:
    """Return which values are within their ±, by plant and noise."""
    found: Dict[Tuple[int, float], List[bool]] = {}
    for outcome in outcomes:
        found.setdefault(outcome.draw[:2], []).extend(outcome.inside.values())
    return found


def identify_one(draw: Draw) -> Outcome:
    """Identify a plant from one record."""
    model = PLANTS[draw.plant]
    duration = DURATION * model.time_constant
    given, inputs = numpy.array([list(one) for one in excitation(-1.0, 1.0, duration)], float).T
    times = numpy.linspace(0.0, duration, OUTPUTS)
    blank = record_of(given, inputs, times, times)
    outputs = responses(blank, candidate(model, model.offset)[None, :])[0]
    # Each plant has its own noise: otherwise a rare draw would count once for each plant.
    seeds = [draw.seed, draw.plant, int(10.0 * draw.alike)]
    noises = numpy.random.RandomState(seeds).normal(0.0, 1.0, OUTPUTS)
    noises[1:] *= math.sqrt(1.0 - draw.alike**2)
    noises = NOISE * numpy.ptp(outputs) * lfilter([1.0], [1.0, -draw.alike], noises)
    try:
        found = identify(record_of(given, inputs, times, outputs + noises))
    except IdentificationError as error:
        return Outcome(draw, {}, [str(error)], True)
    inside, wrong = {}, []
    for name in Model._fields:
        value, true = getattr(found.model, name), getattr(model, name)
        width = getattr(found.uncertainty, name)
        absent = Model._field_defaults.get(name)
        if name != "dead_time" and (value == absent) != (true == absent):
            wrong.append(f"{name} {value:.4g} for {true:g}")
        elif math.isfinite(width):
            inside[name] = abs(value - true) <= width
    return Outcome(draw, inside, wrong, not found.test.fits)


def _is_kept(inside: List[bool]) -> bool:
    return bool(inside) and LEAST <= 100.0 * sum(inside) / len(inside) <= MOST


def _between(what: str, inside: List[bool]) -> Check:
    share = 100.0 * sum(inside) / max(1, len(inside))
    bound = f"{LEAST:g} to {MOST:g} %"
    return Check(what, bound, f"{share:.1f} % of {len(inside)}", _is_kept(inside))
