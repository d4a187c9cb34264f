"""The phase tracker against the exact sine that its samples were rounded from."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.conditioning.phase_intervals import TURN, intersect, nearest_first, phases_of_sine
from basic_comms.conditioning.phase_tracking import PhaseTracker

# Half a unit in the last place of float32, relative: how far the frequency field may be off.
ROUNDING = 2.0**-24


def float32(value):
    """Round to float32."""
    return struct.unpack("f", struct.pack("f", value))[0]


class Line:
    """A sine source of exact phase, wired to a tracker by rounded fields."""

    def __init__(self, amplitude=2.0, frequency=6.2832, phase=0.0, time=0.0):
        self.amplitude = amplitude
        self.frequency = frequency
        self.phase = phase
        self.time = time
        self.offset = 0.0
        self.tracker = PhaseTracker()

    def advance(self, step):
        """Let time pass; return by how much the phase advanced."""
        before = self.time
        self.time += step
        angle = self.frequency * (self.time - before)
        self.phase += angle
        return angle

    def deliver(self, outlier=0.0):
        """Hand over a sample, falsified if asked; return the tracker's error in amplitudes."""
        quadrature = self.tracker.update(
            float32(self.amplitude),
            float32(self.frequency),
            self.time,
            float32(self.offset + self.amplitude * math.sin(self.phase) + outlier),
            self.offset,
        )
        return abs(quadrature / self.amplitude - math.cos(self.phase))


class Promise:
    """The error allowed, sample by sample, in amplitudes."""

    def __init__(self):
        self.settled = False
        self.passed = 0.0

    def after(self, angle):
        """Return the bound once the phase has advanced by an angle since the previous sample."""
        # Half turns add no information on a sampled sine: only the rest counts.
        self.passed += abs(math.remainder(angle, math.pi))
        self.settled |= abs(math.sin(angle)) >= 0.02 or self.passed >= 0.05
        if self.settled:
            # A step of many turns is as uncertain as the rounded frequency makes it.
            return 1e-5 + ROUNDING * abs(angle)
        return max(1e-5, 2e-7 / max(abs(math.sin(angle)), 1e-9))


def powers_of_ten(low, high):
    """Floats whose decades are equally likely."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


signs = st.sampled_from([1.0, -1.0])
near_crest = st.builds(
    lambda crest, distance, side: crest * 0.5 * math.pi + side * distance,
    signs,
    powers_of_ten(-7, -1),
    signs,
)
starts = st.just(0.0) | st.floats(0.0, 1e3) | st.floats(86400.0, 864000.0)


@st.composite
def lines(draw):
    """Draw a source and its sampling step: 1 mrad/s and up, slow and far beyond Nyquist."""
    angle = draw(powers_of_ten(-4, 1))
    step = max(angle / draw(powers_of_ten(-3, 4)), 1e-5)
    line = Line(
        amplitude=draw(signs) * draw(powers_of_ten(-6, 6)),
        frequency=draw(signs) * angle / step,
        phase=draw(st.floats(-math.pi, math.pi) | near_crest),
        time=draw(starts),
    )
    return line, step


@given(lines(), st.lists(st.floats(0.5, 1.5), min_size=15, max_size=15))
def test_error_is_bounded_for_any_start(drawn, stretches):
    line, step = drawn
    promise = Promise()
    line.deliver()
    for stretch in stretches:
        allowed = promise.after(line.advance(step * stretch))
        assert line.deliver() <= allowed


@given(lines(), st.data())
def test_error_is_bounded_through_live_changes(drawn, data):
    line, step = drawn
    promise = Promise()
    line.deliver()
    for _ in range(8):
        line.amplitude *= data.draw(signs) * data.draw(powers_of_ten(-1, 1))
        line.frequency *= data.draw(st.floats(-1.5, 1.5))
        for _ in range(3):
            allowed = promise.after(line.advance(step))
            assert line.deliver() <= allowed


def sweep(line, slope, count, step=0.01):
    """Raise the frequency gradually; return the errors meanwhile."""
    errors = []
    for _ in range(count):
        # The phase advances with the mean frequency, the sample tells the one at its end.
        line.frequency += 0.5 * slope * step
        line.advance(step)
        line.frequency += 0.5 * slope * step
        errors.append(line.deliver())
    return errors


@given(st.floats(-10.0, 10.0), st.floats(1.0, 100.0), st.floats(-math.pi, math.pi), signs)
def test_a_sweep_is_followed_exactly(slope, frequency, phase, sign):
    line = Line(frequency=sign * frequency, phase=phase)
    line.deliver()
    # A gradual change may be distinguished from a sudden one only after a swing.
    assert max(sweep(line, slope, 700)[600:]) <= 1e-5


def test_a_logarithmic_sweep_is_followed_exactly():
    line = Line(frequency=1.0)
    line.deliver()
    for _ in range(1000):
        growth = math.exp(0.005)
        mean = line.frequency * (growth - 1.0) / 0.005
        line.phase += mean * 0.01
        line.time += 0.01
        line.frequency *= growth
        assert line.deliver() <= 1e-5


@given(near_crest, st.floats(10.0, 60.0))
def test_a_sudden_change_after_a_sweep_is_sudden_again(phase, frequency):
    line = Line(frequency=5.0)
    line.deliver()
    sweep(line, 10.0, 200)
    line.advance(0.01)
    line.deliver()
    line.advance((phase - line.phase) % TURN / line.frequency)
    line.deliver()
    for line.frequency in (frequency, 7.0):
        # So close to the crest, samples contain hardly any information.
        line.advance(1e-5)
        assert line.deliver() <= 1e-5


@given(st.floats(20.0, 60.0))
def test_sudden_change_within_sweep_is_detected(frequency):
    line = Line(frequency=5.0)
    line.deliver()
    sweep(line, 10.0, 200)
    while abs(math.cos(line.phase)) < 0.3:
        sweep(line, 10.0, 1)
    line.frequency = frequency
    line.advance(0.01)
    assert line.deliver() <= 1e-4


@given(lines(), st.lists(st.integers(1, 40), min_size=15, max_size=15))
def test_lost_samples_cost_no_more_than_the_rounding_of_frequency(drawn, gaps):
    line, step = drawn
    promise = Promise()
    line.deliver()
    for gap in gaps:
        allowed = promise.after(line.advance(step * gap))
        assert line.deliver() <= allowed


@given(near_crest, powers_of_ten(-5, -3))
def test_slow_start_at_a_crest_is_settled_after_50_mrad(phase, angle):
    line = Line(phase=phase, frequency=1.0)
    line.deliver()
    while line.time < 0.06:
        line.advance(angle if line.time < 0.04 else 0.001)
        if line.time < 0.05:
            assert line.deliver() <= 2e-7 / math.sin(angle)
        else:
            assert line.deliver() <= 1e-5


def test_two_samples_around_a_crest_keep_the_promise_whatever_the_first_guess():
    for exponent in range(-24, -4):
        angle = 2.0 ** (exponent / 1.3)
        for part in range(-300, 300, 7):
            line = Line(frequency=angle, phase=-0.5 * math.pi + angle * part / 97.0, time=1.0)
            line.deliver()
            line.advance(1.0)
            assert line.deliver() <= 2e-7 / math.sin(angle)


def test_very_slow_samples_are_pieced_together():
    line = Line(frequency=1e-3, phase=1.9)
    line.deliver()
    for _ in range(1000):
        line.advance(1e-4)
        error = line.deliver()
    assert error <= 1e-5


@pytest.mark.parametrize("gap", [1e7, 1e10])
def test_a_gap_of_too_many_turns_is_as_good_as_a_start(gap):
    # A frequency without rounding error: the phase w t is exact at any time.
    line = Line(frequency=6.25)
    for _ in range(10):
        line.advance(0.125)
        line.deliver()
    line.advance(gap)
    assert line.deliver() <= 1e-5


def test_rounding_of_a_large_time_does_not_lose_the_phase():
    frequency = 1e6
    tracker = PhaseTracker()
    for index in range(2000):
        time = 864000.0 + index * 1e-6
        angle = frequency * time
        quadrature = tracker.update(1.0, frequency, time, float32(math.sin(angle)))
        if index:
            assert abs(quadrature - math.cos(angle)) <= 2e-5


def test_a_day_later_it_is_as_exact_as_in_the_first_second():
    line = Line(frequency=6.2832)
    line.deliver()
    worst = 0.0
    for _ in range(216000):
        line.advance(0.4)
        worst = max(worst, line.deliver())
    assert line.time == pytest.approx(86400.0)
    assert worst < 1e-6


@pytest.mark.parametrize("stand_still", [0.0, math.pi / 0.1, -TURN / 0.1])
@given(phase=near_crest | st.floats(-math.pi, math.pi))
def test_keeps_the_phase_while_samples_repeat_themselves(stand_still, phase):
    line = Line(phase=phase)
    line.deliver()
    for _ in range(5):
        line.advance(0.1)
        line.deliver()
    line.frequency = float32(stand_still)
    for _ in range(50):
        line.advance(0.1)
        assert line.deliver() <= 2e-5


@given(lines(), st.sampled_from([0, 1, 20]), st.integers(1, 20))
def test_keeps_its_course_without_amplitude(drawn, before, count):
    line, step = drawn
    promise = Promise()
    line.deliver()
    for _ in range(before):
        promise.after(line.advance(step))
        line.deliver()
    start = line.phase
    for _ in range(count):
        line.advance(step)
        assert line.tracker.update(0.0, float32(line.frequency), line.time, 0.0) == 0.0
    line.advance(step)
    assert line.deliver() <= promise.after(line.phase - start)


@given(st.floats(0.05, 3.0), st.floats(0.01, TURN - 0.01), st.floats(-math.pi, math.pi))
def test_finds_a_sine_that_jumped_from_two_new_samples(angle, jump, phase):
    line = Line(frequency=angle, phase=phase)
    for _ in range(20):
        line.advance(1.0)
        line.deliver()
    line.phase += jump
    # A jump may hide from its first sample, where the sine has the same value on both courses.
    for _ in range(3):
        line.advance(1.0)
        line.deliver()
    for _ in range(20):
        line.advance(1.0)
        assert line.deliver() <= 1e-5


@given(st.floats(0.01, 0.5), st.floats(-math.pi, math.pi), st.floats(0.1, 5.0), signs)
def test_outliers_do_not_turn_it_from_its_course(angle, phase, size, sign):
    line = Line(frequency=angle, phase=phase)
    for index in range(60):
        line.advance(1.0)
        line.deliver()
    for index in range(50):
        line.advance(1.0)
        assert line.deliver(outlier=sign * size * (index % 3 == 0)) <= 1e-4


@pytest.mark.parametrize("ratio", [3.0, 100.0, 1e6])
def test_follows_the_swing_of_a_signal_far_above_its_stated_amplitude(ratio):
    line = Line(frequency=0.3, phase=1.0)
    errors = []
    for _ in range(400):
        line.advance(1.0)
        errors.append(line.deliver(outlier=(ratio - 1.0) * line.amplitude * math.sin(line.phase)))
    assert max(errors[200:]) < 0.3


@given(st.floats(0.1, 1.0), st.floats(1e-6, 1e-3))
def test_an_inexact_sine_is_followed_about_as_well_as_it_is_made(angle, jitter):
    line = Line(frequency=angle)
    errors = []
    for index in range(200):
        line.advance(1.0)
        errors.append(line.deliver(outlier=2.0 * jitter * math.sin(index * index)))
    errors.sort()
    assert errors[len(errors) * 9 // 10] <= 20.0 * jitter
    # Near a crest a small error of the value may look like a large error of the phase.
    assert errors[-1] <= 5.0 * math.sqrt(jitter)


def test_pulls_a_phase_that_is_off_towards_an_inexact_sine():
    line = Line(frequency=0.5)
    for index in range(200):
        if index == 50:
            line.phase += 2.0
        line.advance(1.0)
        error = line.deliver(outlier=0.02 * math.sin(index * index))
        if index > 150:
            assert error < 0.05


@given(st.floats(-20.0, 20.0), st.floats(0.05, 3.0), st.floats(-math.pi, math.pi))
def test_takes_the_input_offset_off(offset, angle, phase):
    line = Line(frequency=angle, phase=phase)
    line.offset = offset
    line.deliver()
    # The sum is rounded in the message, so the offset reduces precision.
    allowed = 1e-5 + 2.0 * ROUNDING * abs(offset) / abs(math.sin(angle))
    for _ in range(20):
        line.advance(1.0)
        assert line.deliver() <= allowed


@pytest.mark.parametrize("seen", [1, 10])
@pytest.mark.parametrize("backwards", [0.0, 0.05, 3600.0])
def test_tracking_restarts_when_time_does_not_advance(backwards, seen):
    line = Line(time=86400.0 + backwards - 0.1 * seen)
    for _ in range(seen):
        line.advance(0.1)
        line.deliver()
    assert line.tracker.restarts == 0
    line.time -= backwards
    line.phase = line.frequency * line.time + 0.02
    assert line.deliver() <= 1e-5
    assert line.tracker.restarts == 1
    for _ in range(10):
        line.advance(0.1)
        assert line.deliver() <= 1e-5
    assert line.tracker.restarts == 1


@pytest.mark.parametrize("time", [0.0, 0.3, 40.0, 86400.0])
def test_a_generator_left_alone_is_known_from_the_first_sample(time):
    line = Line(phase=6.2832 * time, time=time)
    assert line.deliver() <= 1e-5


wire = st.floats(width=32, allow_nan=False, allow_infinity=False)
clock = st.floats(allow_nan=False, allow_infinity=False) | st.floats(0.0, 10.0)


@given(st.lists(st.tuples(wire, wire, clock, wire), max_size=12))
def test_any_finite_samples_give_a_quadrature_within_the_amplitude(samples):
    tracker = PhaseTracker()
    for amplitude, frequency, time_x, signal_y in samples:
        assert abs(tracker.update(amplitude, frequency, time_x, signal_y)) <= abs(amplitude)


def test_an_infinite_change_of_phase_is_no_sweep():
    tracker = PhaseTracker()
    tracker.update(1.0, 1e38, 0.0, 1.0)
    assert abs(tracker.update(1.0, 0.0, 1e300, 0.0)) <= 1.0


@given(st.floats(-math.pi, math.pi) | near_crest, st.floats(1e-9, 1e-2), st.floats(-1.0, 1.0))
def test_phases_of_sine_contain_true_phase(phase, tolerance, part):
    found = phases_of_sine(math.sin(phase) + 0.999 * part * tolerance, tolerance)
    assert any(abs(math.remainder(phase - centre, TURN)) <= half + 1e-12 for centre, half in found)
    for centre, half in found:
        for side in (-1.0, 0.0, 1.0):
            assert abs(math.sin(centre + side * half) - math.sin(phase)) <= 2.001 * tolerance


def test_no_phase_has_a_sine_beyond_one():
    assert phases_of_sine(1.1, 0.05) == []
    assert phases_of_sine(-1.1, 0.05) == []


def test_every_phase_fits_a_sine_that_is_not_known():
    ((_, half),) = phases_of_sine(0.3, 5.0)
    assert half == pytest.approx(math.pi)


def test_intersection_is_independent_of_whole_turns():
    ((centre, half),) = intersect([(1.0 + 3 * TURN, 0.2)], [(1.3, 0.2), (2.0, 0.2)])
    assert centre == pytest.approx(1.15)
    assert half == pytest.approx(0.05)
    assert intersect([(1.0, 0.2)], [(2.0, 0.2)]) == []


def test_the_nearest_interval_is_the_nearest_on_the_circle():
    assert nearest_first([(0.0, 0.1), (3.2, 0.2)], -3.0) == [(3.2, 0.2), (0.0, 0.1)]
    assert nearest_first([(0.0, 0.1), (3.2, 0.2)], -1.0) == [(0.0, 0.1), (3.2, 0.2)]
