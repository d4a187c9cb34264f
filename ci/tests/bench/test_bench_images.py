"""Tests of the figures of large messages, from records of both ends."""

import pytest

from ci.benchmark import images
from ci.benchmark.record import Sample


def test_figures_count_samples_of_the_interval_for_all_subscribers():
    sent = [Sample(float(number), number) for number in range(10)]
    first = [Sample(number + 0.002, number) for number in range(10)]
    second = [Sample(number + 0.004, number) for number in range(10) if number != 5]
    found = images.figures(sent, [first, second], 2.5, 8.5, 12.0)
    assert found["lost"] == 1
    assert found["p50_ms"] == pytest.approx(2.0)
    assert found["p99_ms"] == pytest.approx(4.0)
    assert found["cpu_percent"] == 12.0


def test_nothing_received_is_an_error():
    with pytest.raises(ValueError, match="no message"):
        images.figures([Sample(1.0, 0)], [[]], 0.0, 2.0, 1.0)


def test_each_subject_is_of_a_stack_a_size_and_a_number_of_subscribers():
    all_but_points_of_rclpy = len(images.STACKS) * len(images.MESSAGES) * len(images.COUNTS) - 2
    assert len(images.CASES) == all_but_points_of_rclpy
    assert images.CASES["rospy, 6.2 MB to 3"] == images.Case("rospy", "6.2 MB", 3)
