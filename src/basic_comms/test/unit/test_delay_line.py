"""The delay line against the shapes that its samples were taken from."""

import math
import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.conditioning.delay_line import PhaseDelayLine

TURN = 2.0 * math.pi


class Feed:
    """A periodic shape of exact phase, fed to a delay line."""

    def __init__(self, shape=math.sin, frequency=1.0):
        self.shape = shape
        self.frequency = frequency
        self.phase = 0.0
        self.time = 0.0
        self.line = PhaseDelayLine()
        self.push()

    def push(self):
        """Feed a sample."""
        self.line.push(self.frequency, self.time, self.shape(self.phase))

    def run(self, angle, step):
        """Feed samples a step apart until the phase has advanced by an angle."""
        for _ in range(math.ceil(angle / step)):
            self.time += step / abs(self.frequency)
            self.phase += math.copysign(step, self.frequency)
            self.push()

    def error(self, lead):
        """Return how far the value that leads by a phase is from the shape there."""
        return abs(self.line.value(lead) - self.shape(self.phase + lead))


def triangle(phase):
    """Return a triangle of unit peak."""
    return 2.0 / math.pi * math.asin(math.sin(phase))


def square(phase):
    """Return a square wave of unit peak whose edges are between the tests' samples."""
    return 1.0 if (phase + 0.01) % TURN < math.pi else -1.0


leads = st.floats(-10.0, 10.0)
signs = st.sampled_from([1.0, -1.0])


@given(
    st.lists(st.floats(-1e6, 1e6, width=32), min_size=3, max_size=12), st.integers(-20, 20), signs
)
def test_a_lead_by_whole_samples_gives_the_sample_itself(period, lead, sign):
    count = len(period)
    feed = Feed(lambda phase: period[round(phase / TURN * count) % count], sign)
    feed.run(2.1 * TURN, TURN / count)
    # Rounding may put the phase on either side of a sample; around it the value is continuous.
    span = max(period) - min(period)
    assert feed.error(TURN * lead / count) <= 1e-9 * span


@given(
    st.floats(0.01, 0.7),
    leads,
    st.lists(st.tuples(st.floats(0.75, 1.4), st.floats(0.5, 2.0)), min_size=4, max_size=12),
    signs,
)
def test_a_sine_is_shifted_whatever_frequency_and_rate_do(step, lead, changes, sign):
    feed = Feed(frequency=sign)
    feed.run(TURN + 2.0 * step, step)
    for stretch, change in changes:
        feed.frequency *= change
        feed.run(stretch * step, stretch * step)
        widest = 1.4 * step
        if (-sign * lead) % TURN < widest:
            assert feed.error(lead) <= widest**2 / 8.0
        else:
            # The remainder of a parabola through samples that far apart.
            assert feed.error(lead) <= widest**3 / 12.0 + 1e-9


@pytest.mark.parametrize(
    "values, between_1_and_2",
    [
        ([0.0, 1.0, 4.0, 9.0, 16.0], 2.25),
        ([0.0, 1.0, 4.0, 99.0, 99.0], 2.25),
        ([99.0, 1.0, 4.0, 9.0, 16.0], 2.25),
    ],
)
def test_parabola_is_reproduced_exactly(values, between_1_and_2):
    line = PhaseDelayLine()
    for number, value in enumerate(values):
        line.push(1.0, 0.1 * number, value)
    assert line.value(-0.25) == pytest.approx(between_1_and_2)
    assert line.value(-0.05) == pytest.approx((values[3] + values[4]) / 2.0)
    assert line.value(-0.35) == pytest.approx((values[0] + values[1]) / 2.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_straight_lines_are_exact(direction):
    feed = Feed(triangle, direction)
    feed.run(TURN, TURN / 16)
    for _ in range(40):
        feed.run(TURN / 16, TURN / 16)
        for lead in (0.1, 1.0, 2.0, 3.0, -0.3):
            assert feed.error(lead) < 1e-9


@given(st.floats(0.02, 1.0), leads)
def test_edges_do_not_ring(step, lead):
    feed = Feed(square)
    feed.run(TURN + 2.0 * step, step)
    for _ in range(30):
        feed.run(step, step)
        assert abs(feed.line.value(lead)) <= 1.0 + 1e-12
        to_edge = abs(math.remainder(feed.phase + lead + 0.01, math.pi))
        if to_edge > step:
            assert feed.error(lead) < 1e-12


@pytest.mark.parametrize("step", [1e-4, 0.003, 0.0031, 0.05])
def test_fine_sampling_is_thinned_without_loss(step):
    feed = Feed()
    feed.run(1.1 * TURN, step)
    for lead in (1e-4, 0.1, 1.5, 3.0, 6.0, -0.06, -0.5):
        feed.run(step, step)
        assert feed.error(lead) <= step**3 / 12.0 + 1e-8


@pytest.mark.parametrize("step", [0.0, 2e-4, 0.00306, 3.0])
def test_memory_is_bounded(step):
    feed = Feed()
    tracemalloc.start()
    for _ in range(40000):
        feed.time += 1e-3
        feed.line.push(step / 1e-3, feed.time, feed.time)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1e6


def test_without_lead_the_sample_passes_even_at_first():
    feed = Feed(lambda phase: 4.0)
    for lead in (0.0, TURN, -3.0 * TURN):
        assert feed.line.value(lead) == 4.0


def test_before_the_first_sample_there_is_no_value():
    assert PhaseDelayLine().value(0.0) is None


@given(st.floats(0.01, TURN - 0.01), signs)
def test_no_value_until_the_memory_reaches_back(lag, sign):
    feed = Feed(frequency=sign)
    for _ in range(100):
        feed.run(0.1, 0.1)
        assert (feed.line.value(-sign * lag) is None) == (abs(feed.phase) < lag)


def test_a_signal_at_rest_keeps_its_shifted_value():
    feed = Feed()
    feed.run(2.0 * TURN, 0.1)
    before = feed.line.value(1.0)
    feed.frequency = 0.0
    for _ in range(5):
        feed.time += 1.0
        feed.push()
        assert feed.line.value(1.0) == pytest.approx(before, abs=1e-9)
    feed.frequency = 1.0
    for _ in range(80):
        feed.run(0.1, 0.1)
        assert feed.error(1.0) < 1e-3


@given(st.floats(1.1, 3.0), st.floats(0.2, TURN))
def test_a_signal_that_turns_back_is_known_from_the_period_before(turns, back):
    feed = Feed(lambda phase: math.sin(phase) + 0.3 * math.cos(2.0 * phase))
    feed.run(turns * TURN, 0.1)
    for _ in range(2):
        feed.frequency *= -1.0
        for step in (0.1, 0.1, back):
            feed.run(step, 0.1)
            assert all(feed.error(0.2 * index) <= 5e-3 for index in range(32))


def test_a_signal_that_turns_back_too_soon_has_to_show_its_period_first():
    feed = Feed()
    feed.run(5.0, 0.1)
    feed.frequency = -1.0
    feed.run(0.1, 0.1)
    assert feed.line.value(1.0) is None
    feed.run(TURN, 0.1)
    assert feed.error(1.0) < 1e-3


@pytest.mark.parametrize("jump", [0.0, -1.0, -1e6, TURN, 1e9, 1e308])
def test_a_break_in_time_clears_the_memory(jump):
    feed = Feed()
    feed.run(3.0 * TURN, 0.1)
    feed.time += jump
    feed.push()
    assert feed.line.value(1.0) is None
    if abs(jump) < 1e300:
        feed.run(TURN, 0.1)
        assert feed.error(1.0) < 1e-3


def test_a_gap_of_less_than_a_period_is_bridged():
    feed = Feed(triangle)
    feed.phase = -0.5 * math.pi
    feed.run(2.0 * TURN, TURN / 40)
    feed.run(TURN / 4, TURN / 4)
    assert feed.error(-TURN / 5) < 1e-9
    assert feed.error(-TURN / 20) < 1e-9


def test_a_gap_beside_an_edge_is_not_overshot():
    line = PhaseDelayLine()
    for phase, value in [(1.0, -1.0), (1.001, 1.0), (4.0, 1.0), (4.001, -1.0), (5.0, -1.0)]:
        line.push(1.0, phase, value)
    for lag in (1.5, 2.0, 3.0, 3.9):
        assert line.value(-lag) == pytest.approx(1.0)


def test_samples_hardly_apart_do_not_overflow():
    line = PhaseDelayLine()
    for time, frequency, value in [(1.0, 1.0, 0.0), (1.5, 1e-301, 1.0), (2.0, 1e-320, -1e38)]:
        line.push(frequency, time, value)
    for lead in (-5e-324, -1e-310, -4e-302, -3e-301):
        assert math.isfinite(line.value(lead) or 0.0)


numbers = st.floats(-1e9, 1e9)


@given(st.lists(st.tuples(numbers, st.floats(0, 10), st.floats(-1, 1)), max_size=30), leads)
def test_any_samples_give_values_of_about_their_own_size(samples, lead):
    line = PhaseDelayLine()
    time = 0.0
    for frequency, step, value in samples:
        time += step
        line.push(frequency / 1e8, time, value)
        shifted = line.value(lead)
        assert shifted is None or abs(shifted) <= 3.0
