"""Tests of the motor's status texts."""

import pytest

from pid_control.plant.status import MAX_SPEED, NOT_TURNING, TURNING, status_of


@pytest.mark.parametrize(
    "speed, status",
    [
        (13.0, MAX_SPEED),
        (-13.0, MAX_SPEED),
        (12.999, TURNING),
        (-0.014, TURNING),
        (0.013, NOT_TURNING),
        (-0.012, NOT_TURNING),
        (0.0, NOT_TURNING),
    ],
)
def test_status_of_depends_on_speed_magnitude(speed: float, status: str) -> None:
    assert status_of(speed, 13.0) == status
