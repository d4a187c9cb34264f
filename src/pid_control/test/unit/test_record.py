"""Tests of making records from samples."""

import math

import numpy

from pid_control.identification.record import record_of

TIMES = numpy.linspace(0.0, 10.0, 101)


def test_sporadic_input_is_0_before_its_first_message() -> None:
    record = record_of([3.0, 6.0], [1.0, 2.0], TIMES, TIMES)
    assert record.changed_at.tolist() == [0.0, 3.0, 6.0]
    assert record.inputs.tolist() == [0.0, 1.0, 2.0]


def test_record_begins_with_a_stream() -> None:
    stream = numpy.arange(2.05, 10.0, 0.1)
    record = record_of(stream, numpy.sin(stream), TIMES, TIMES)
    assert record.changed_at[0] < 0.0 == record.times[0]
    assert len(record.times) == 80
    assert record.left_out == 0


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
    assert len(few.times) == 10
    assert numpy.array_equal(few.outputs, few.times)
    coarse = record.coarse(4)
    assert len(coarse.inputs) == 5
    assert coarse.changed_at[0] == 0.0
    assert numpy.abs(coarse.inputs - 0.01 * coarse.changed_at).max() <= 0.0125 + 1e-9
