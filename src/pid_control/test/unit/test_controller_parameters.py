"""Tests of the controller's parameters and their validation."""

import pytest

from nodekit import ParameterError
from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.controller.pid import PidSettings


def test_pid_settings_have_every_parameter() -> None:
    values = {
        name: number / 16.0
        for number, name in enumerate(PidSettings._fields)
        if name not in ("mode", "anti_windup")
    }
    values["output_min"] = -2.0
    given = ControllerParameters(mode="P", anti_windup="none", **values)
    assert given.pid._asdict() == {**values, "mode": "P", "anti_windup": "none"}


@pytest.mark.parametrize(
    "name, least, largest",
    [
        *((name, -1e6, 1e6) for name in ("kp", "ki", "kd", "feed_forward", "manual_output")),
        ("filter_time", 0.0, 1e3),
        ("set_point_weight", 0.0, 1.0),
        ("output_min", -1e6, 0.999),
        ("output_max", -0.999, 1e6),
        ("dead_zone", 0.0, 1e6),
        ("tracking_time", 1e-9, 1e3),
        ("timeout", 0.01, 60.0),
        ("command_timeout", 0.0, 1e6),
    ],
)
def test_values_up_to_the_bounds_are_accepted(name: str, least: float, largest: float) -> None:
    for value, beyond in ((least, least - 0.01), (largest, largest + 0.01)):
        assert getattr(ControllerParameters(**{name: value}), name) == value
        with pytest.raises(ParameterError, match=name):
            ControllerParameters(**{name: beyond})


def test_limits_must_be_in_order() -> None:
    with pytest.raises(ParameterError, match="output_min must be below output_max"):
        ControllerParameters(output_min=1.0)
