"""Noise against its documented laws; the PRBS against scipy and the algebra of its register."""

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal, stats

from basic_comms.signals.noise import Noise
from basic_comms.signals.prbs import TAPS, Prbs

COUNT = 20_000
ORDERS = sorted(TAPS)


@pytest.mark.parametrize("draw", [Noise.uniform, Noise.gaussian])
def test_a_seed_gives_one_sequence(draw):
    def sequence(seed):
        noise = Noise(seed)
        return [draw(noise) for _ in range(100)]

    assert sequence(7) == sequence(7)
    assert sequence(7) != sequence(8)


def test_the_sequence_of_a_seed_is_that_of_every_release():
    noise = Noise(1)
    assert [noise.uniform() for _ in range(2)] == [-0.7312715117751976, 0.6948674738744653]
    noise = Noise(1)
    assert [noise.gaussian() for _ in range(2)] == pytest.approx(
        [0.10290296402674683, -0.018032384955366788]
    )


def test_uniform_noise_is_uniform_and_white():
    noise = Noise(3)
    values = numpy.array([noise.uniform() for _ in range(COUNT)])
    assert stats.kstest(values, stats.uniform(-1.0, 2.0).cdf).pvalue > 0.01
    assert abs(numpy.corrcoef(values[1:], values[:-1])[0, 1]) < 0.03


def test_gaussian_noise_is_a_normal_law_cut_at_three_standard_deviations_and_white():
    noise = Noise(3)
    values = numpy.array([noise.gaussian() for _ in range(COUNT)])
    law = stats.truncnorm(-3.0, 3.0, scale=1.0 / 3.0)
    assert stats.kstest(values, law.cdf).pvalue > 0.01
    assert abs(numpy.corrcoef(values[1:], values[:-1])[0, 1]) < 0.03
    assert law.std() == pytest.approx(0.9866 / 3.0, rel=1e-4)


@given(st.integers(0, 2**31 - 1))
def test_gaussian_noise_stays_within_one(seed):
    noise = Noise(seed)
    assert all(-1.0 <= noise.gaussian() <= 1.0 for _ in range(1000))


def times_modulo(one, other, polynomial):
    """Multiply two polynomials over GF(2), as bit masks, modulo a third."""
    product = 0
    for shift in range(other.bit_length()):
        if other >> shift & 1:
            product ^= one << shift
    while product.bit_length() >= polynomial.bit_length():
        product ^= polynomial << (product.bit_length() - polynomial.bit_length())
    return product


def power_of_x(exponent, polynomial):
    power, square = 1, times_modulo(2, 1, polynomial)
    while exponent:
        if exponent & 1:
            power = times_modulo(power, square, polynomial)
        square = times_modulo(square, square, polynomial)
        exponent >>= 1
    return power


def prime_factors(number):
    divisor = 2
    while divisor * divisor <= number:
        if number % divisor == 0:
            yield divisor
            number //= divisor
        else:
            divisor += 1
    yield number


@pytest.mark.parametrize("order", ORDERS)
def test_the_period_is_the_longest_possible(order):
    """The order of x in GF(2)[x] modulo the polynomial is 2**order - 1 and no divisor of it."""
    period = 2**order - 1
    polynomial = 2**order + 1 + sum(2**exponent for exponent in TAPS[order])
    assert Prbs(order, 0).period == period
    assert power_of_x(period, polynomial) == 1
    for factor in prime_factors(period):
        if factor < period:
            assert power_of_x(period // factor, polynomial) != 1


def test_every_order_from_2_to_31_is_offered():
    assert ORDERS == list(range(2, 32))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("seed", [0, 12345])
def test_the_chips_equal_scipy(order, seed):
    prbs = Prbs(order, seed)
    length = min(prbs.period, 5000)
    chips = [(prbs.chip(index) + 1) // 2 for index in range(length)]
    state = [(prbs.chip(index) + 1) // 2 for index in range(order)]
    expected, _ = signal.max_len_seq(order, state=state, length=length, taps=TAPS[order])
    assert chips == expected.tolist()


@given(st.sampled_from(ORDERS), st.integers(0, 2**31), st.integers(-(2**40), 2**40))
def test_a_chip_far_away_obeys_the_recurrence_of_the_register(order, seed, index):
    chip = {offset: Prbs(order, seed).chip(index + offset) for offset in (0, order, *TAPS[order])}
    feedback = chip[0]
    for tap in TAPS[order]:
        feedback *= -chip[tap]
    assert chip[order] == feedback


@given(st.lists(st.integers(0, 3000), max_size=30))
def test_chips_are_independent_of_access_order(indices):
    prbs = Prbs(10, 5)
    assert [prbs.chip(index) for index in indices] == [Prbs(10, 5).chip(index) for index in indices]


def test_a_period_is_balanced_and_its_autocorrelation_is_flat():
    prbs = Prbs(9, 77)
    chips = numpy.array([prbs.chip(index) for index in range(prbs.period)])
    assert chips.sum() == 1
    correlation = [int(chips @ numpy.roll(chips, shift)) for shift in range(prbs.period)]
    assert correlation == [prbs.period] + [-1] * (prbs.period - 1)


def test_different_seeds_start_at_different_places():
    windows = set()
    for seed in range(31):
        prbs = Prbs(5, seed)
        windows.add(tuple(prbs.chip(index) for index in range(5)))
    assert len(windows) == 31
