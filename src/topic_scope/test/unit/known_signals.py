"""Two hundred signals with known figures, which measurements must reproduce."""

import math
from typing import Callable, Dict, List, NamedTuple, Tuple

import numpy

from topic_scope.analysis.ring import Ring
from topic_scope.timing.nanoseconds import array_to_ns, to_ns

EPOCH = 1.7e9
#: Number of signals of each kind.
COUNTS = {
    "sine": 60,
    "square": 35,
    "step": 35,
    "noise": 20,
    "chirp": 20,
    "gap": 15,
    "late": 15,
}


class Signal(NamedTuple):
    """Samples with their true figures.

    :param kind: one of :data:`COUNTS`
    :param times: ascending, s
    :param values: the samples
    :param longest: longest time between connected samples [s]
    :param truth: by name of the figure; other figures must not be measurable
    :param sigma: standard deviation of the noise on it, as a part of its height
    """

    kind: str
    times: numpy.ndarray
    values: numpy.ndarray
    longest: float
    truth: Dict[str, float]
    sigma: float


def signals() -> List[Signal]:
    """Return all signals, the same each time."""
    return [
        _MAKERS[kind](numpy.random.RandomState(1000 * index + number))
        for index, (kind, count) in enumerate(COUNTS.items())
        for number in range(count)
    ]


def _scale(random: numpy.random.RandomState) -> Tuple[float, float]:
    """Return the height of a signal, and the offset of its middle in heights."""
    return float(10.0 ** random.uniform(-3.0, 3.0)), float(random.uniform(-3.0, 3.0))


def _scaled(random: numpy.random.RandomState, values: numpy.ndarray) -> numpy.ndarray:
    """Return values from 0 to 1 with another scale and offset."""
    height, middle = _scale(random)
    return height * (values + middle)


def _noise(random: numpy.random.RandomState) -> float:
    """Return the noise on a signal of height 1: none on every other signal."""
    return float(random.choice([0.0, 0.0, 0.002, 0.01, 0.05]))


def _even(random: numpy.random.RandomState, hertz: float, least: float = 2.3) -> numpy.ndarray:
    """Return sample times of a signal of a frequency, for some periods."""
    rate = hertz * math.exp(random.uniform(math.log(least), math.log(200.0)))
    cycles = random.uniform(2.5, 40.0)
    return EPOCH + random.uniform(0.0, 1.0) + numpy.arange(0.0, cycles / hertz, 1.0 / rate)


def _hertz(random: numpy.random.RandomState) -> float:
    """Return a frequency, 1 Hz to 1 kHz."""
    return float(10.0 ** random.uniform(0.0, 3.0))


def _sine_at(
    random: numpy.random.RandomState, times: numpy.ndarray, hertz: float, sigma: float
) -> "Tuple[numpy.ndarray, Dict[str, float]]":
    """Return a sine with its true figures."""
    angle = random.uniform(-math.pi, math.pi)
    height, middle = _scale(random)
    turns = 2.0 * math.pi * hertz * (times - EPOCH) + angle
    noise = sigma * random.standard_normal(len(times))
    values = height * (middle + 0.5 * numpy.sin(turns) + noise)
    truth = {
        "frequency": hertz,
        "rise": math.asin(0.8) / math.pi / hertz,
        "duty": 50.0,
        "phase": math.degrees(angle),
        "amplitude": 0.5 * height,
        "cycle_mean": height * middle,
        "cycle_rms": height * math.sqrt(middle**2 + 0.125 + sigma**2),
    }
    return values, truth


def _sine(random: numpy.random.RandomState) -> Signal:
    hertz, sigma = _hertz(random), _noise(random)
    times = _even(random, hertz)
    values, truth = _sine_at(random, times, hertz, sigma)
    return Signal("sine", times, values, math.inf, truth, sigma)


def _square(random: numpy.random.RandomState) -> Signal:
    hertz, sigma = _hertz(random), _noise(random)
    times, part = _even(random, hertz, 12.0), random.uniform(0.2, 0.8)
    values = (numpy.mod((times - EPOCH) * hertz, 1.0) < part).astype(float)
    values += sigma * random.standard_normal(len(times))
    height, middle = _scale(random)
    square = part * (1.0 + middle) ** 2 + (1.0 - part) * middle**2 + sigma**2
    truth = {
        "frequency": hertz,
        "rise": 0.0,
        "overshoot": 0.0,
        "duty": 100.0 * part,
        "cycle_mean": height * (part + middle),
        "cycle_rms": height * math.sqrt(square),
    }
    return Signal("square", times, height * (values + middle), math.inf, truth, sigma)


def second_order(times: numpy.ndarray, damping: float, omega: float) -> numpy.ndarray:
    """Return the unit step response of a second-order system.

    :param times: s
    :param damping: below 1
    :param omega: undamped frequency [rad/s]
    """
    after = numpy.maximum(times, 0.0)
    damped = omega * math.sqrt(1.0 - damping**2)
    waves = numpy.cos(damped * after) + damping * omega / damped * numpy.sin(damped * after)
    return 1.0 - numpy.exp(-damping * omega * after) * waves


def _step(random: numpy.random.RandomState) -> Signal:
    damping, omega, sigma = (
        random.uniform(0.15, 0.95),
        2.0 * math.pi * _hertz(random),
        _noise(random),
    )
    exact = numpy.linspace(0.0, 8.0 / (damping * omega), 40001)
    answer = second_order(exact, damping, omega)
    rise = exact[numpy.argmax(answer >= 0.9)] - exact[numpy.argmax(answer >= 0.1)]
    settled = exact[numpy.flatnonzero(numpy.abs(answer - 1.0) > 0.02)[-1]]
    left = exact[numpy.argmax(answer > 0.02)]
    spacing = rise / random.uniform(2.0, 60.0)
    length = random.uniform(0.5, 3.0) * (settled - left)
    begin = -random.uniform(4.0, 60.0) * spacing
    since = numpy.arange(begin, settled + length, spacing)
    values = second_order(since, damping, omega) + sigma * random.standard_normal(len(since))
    truth = {
        "rise": rise,
        "overshoot": 100.0 * math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2)),
        "settling": settled - left,
    }
    if random.uniform() < 0.5:
        values = 1.0 - values
    return Signal("step", EPOCH + since, _scaled(random, values), math.inf, truth, sigma)


def _only_noise(random: numpy.random.RandomState) -> Signal:
    count = int(random.randint(50, 4000))
    values = random.choice([random.standard_normal, random.uniform])(size=count)
    times = EPOCH + numpy.arange(count) / _hertz(random)
    return Signal("noise", times, _scaled(random, values), math.inf, {}, 1.0)


def _chirp(random: numpy.random.RandomState) -> Signal:
    first = _hertz(random)
    last = first * random.uniform(1.5, 10.0)
    length = random.uniform(10.0, 40.0) / first
    since = numpy.arange(0.0, length, 1.0 / (last * random.uniform(2.5, 50.0)))
    turns = 2.0 * math.pi * (first * since + (last - first) / length / 2.0 * since**2)
    values = numpy.sin(turns + random.uniform(0.0, 6.0))
    return Signal("chirp", EPOCH + since, _scaled(random, values), math.inf, {}, 0.0)


def _gap(random: numpy.random.RandomState) -> Signal:
    hertz, sigma = _hertz(random), _noise(random)
    times = _even(random, hertz, 5.0)
    step, length = times[1] - times[0], times[-1] - times[0]
    begin = times[0] + random.uniform(0.1, 0.8) * length
    times = times[
        (times < begin) | (times > begin + max(random.uniform(0.1, 0.5) * length, 6 * step))
    ]
    values, truth = _sine_at(random, times, hertz, sigma)
    return Signal("gap", times, values, 5.0 * step, truth, sigma)


def _late(random: numpy.random.RandomState) -> Signal:
    """Return a signal with late and disordered messages."""
    hertz, sigma = _hertz(random), _noise(random)
    times = _even(random, hertz)
    values, truth = _sine_at(random, times, hertz, sigma)
    received = times + random.uniform(0.0, 2.0 / hertz, len(times))
    ring, order = Ring(1e6), received.argsort()
    for some in numpy.array_split(order, max(len(order) // 7, 1)):
        ring.append(array_to_ns(times[some]), values[some], array_to_ns(received[some]))
    times, values, _ = ring.between(to_ns(-math.inf), to_ns(math.inf))
    return Signal("late", times / 1e9, values, math.inf, truth, sigma)


_MAKERS: Dict[str, Callable[[numpy.random.RandomState], Signal]] = {
    "sine": _sine,
    "square": _square,
    "step": _step,
    "noise": _only_noise,
    "chirp": _chirp,
    "gap": _gap,
    "late": _late,
}
