"""Tests of the excitation signal."""

from itertools import groupby

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.identification.excitation import Progress, excitation


@given(st.floats(-5.0, 0.0), st.floats(0.01, 5.0), st.floats(1.0, 100.0))
def test_inputs_are_within_bounds_and_end_with_0(
    least: float, largest: float, seconds: float
) -> None:
    changes = excitation(least, largest, seconds)
    times = [change.time for change in changes]
    values = [change.value for change in changes]
    assert times == sorted(times)
    assert times[0] == 0.0 and times[-1] < seconds
    assert (min(values), max(values)) == (least if least else 0.0, largest)
    assert values[0] == values[-1] == 0.0


def test_excitation_is_a_slow_ramp_and_then_steps() -> None:
    changes = excitation(-0.5, 2.0, 10.0)
    ramp = [(0.01 * number, 0.002 * number) for number in range(400)]
    values = [0.0, 2.0, 0.0, 1.0, 1.6, 0.6, -0.5, 1.2, -0.25, 0.0]
    steps = [(4.0 + 0.6 * number, value) for number, value in enumerate(values)]
    assert numpy.array(changes) == pytest.approx(numpy.array(ramp + steps))


def test_progress_stalled_machine_skips_no_step() -> None:
    changes = excitation(-0.5, 1.0, 4.0)
    progress, inputs, time = Progress(changes, 4.0), [], 100.0
    while not inputs or inputs[-1] is not None:
        inputs.append(progress.input_at(time))
        time += 2.2 if len(inputs) % 100 == 0 else 0.004
    steps = [change.value for change in changes[-10:]]
    runs = [value for value, _ in groupby(inputs[:-1])]
    assert runs[-10:] == steps
    assert inputs.count(None) == 1 and inputs[-2] == 0.0
    lasted = 0.004 * len(inputs)
    # Of each of its standstills a tenth of a second counts.
    assert abs(lasted + (len(inputs) // 100) * (0.1 - 0.004) - 4.0) < 0.01
