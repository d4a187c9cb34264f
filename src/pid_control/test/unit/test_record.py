"""Tests of making records from samples."""

import math

import numpy
import pytest

from pid_control.identification.record import record_of

TIMES = numpy.linspace(0.0, 10.0, 101)


def test_sporadic_input_is_0_before_its_first_message() -> None:
    record = record_of([53.0, 56.0], [1.0, 2.0], 50.0 + TIMES, TIMES)
    assert record.changed_at.tolist() == [0.0, 3.0, 6.0]
    assert record.inputs.tolist() == [0.0, 1.0, 2.0]


def test_record_begins_with_a_stream() -> None:
    stream = numpy.arange(2.05, 10.0, 0.1)
    record = record_of(stream, numpy.sin(stream), TIMES, TIMES)
    assert record.changed_at[0] < 0.0 == record.times[0]
    assert len(record.times) == 80
    assert record.left_out == 0


@pytest.mark.parametrize("interval, is_stream", [(0.19, True), (0.21, False)])
def test_input_of_more_than_5_messages_a_second_is_a_stream(
    interval: float, is_stream: bool
) -> None:
    given_at = numpy.arange(2.05, 10.0, interval)
    record = record_of(given_at, numpy.arange(1.0, len(given_at) + 1.0), TIMES, 7.0 * TIMES)
    assert record.inputs[0] == (1.0 if is_stream else 0.0)
    assert record.outputs[0] == pytest.approx(7.0 * 2.1 if is_stream else 0.0)


def test_last_of_simultaneous_inputs_counts() -> None:
    times, inputs = [0.0] + [3.0] * 20, list(range(21))
    record = record_of(times, inputs, TIMES, TIMES)
    at_3_s = numpy.searchsorted(record.changed_at, 3.0, side="right") - 1
    assert record.inputs[at_3_s] == 20.0


def test_times_are_in_order_and_count_from_the_first_output() -> None:
    epoch = 1.8e9
    order = numpy.random.RandomState(0).permutation(101)
    record = record_of([epoch, epoch + 1.0], [0.0, 1.0], epoch + TIMES[order], 7.0 * TIMES[order])
    assert numpy.allclose(record.times, TIMES, atol=1e-6)
    assert numpy.allclose(record.outputs, 7.0 * TIMES)
    assert (record.duration, record.span) == (10.0, 70.0)
    assert abs(record.interval - 0.1) < 1e-6


def test_non_finite_samples_are_left_out_and_counted() -> None:
    outputs = TIMES.copy()
    outputs[[3, 50]] = math.nan, math.inf
    record = record_of([0.0, 1.0, 2.0], [0.0, math.nan, 1.0], TIMES, outputs)
    assert record.left_out == 3
    assert len(record.times) == 99
    assert record.changed_at.tolist() == [0.0, 2.0]


def test_fewer_outputs_and_a_coarser_input_are_parts_of_it() -> None:
    record = record_of(TIMES, 0.01 * TIMES, TIMES, TIMES)
    few = record.thinned(10)
    assert few.times.tolist() == TIMES[::11].tolist() and few.inputs is record.inputs
    # The median of the intervals is not that of a gap.
    assert record._replace(times=numpy.append(TIMES, 50.0)).interval == pytest.approx(0.1)
    assert record.thinned(101).times.tolist() == TIMES.tolist()
    assert numpy.array_equal(few.outputs, few.times)
    coarse = record.coarse(4)
    assert len(coarse.inputs) == 5
    assert coarse.changed_at[0] == 0.0 and coarse.outputs is record.outputs
    assert coarse.inputs == pytest.approx([0.0, 0.025, 0.05, 0.075, 0.1])
    opposite = record._replace(inputs=-record.inputs).coarse(4)
    assert opposite.inputs == pytest.approx(-coarse.inputs)
    assert numpy.abs(coarse.inputs - 0.01 * coarse.changed_at).max() <= 0.0125 + 1e-9
