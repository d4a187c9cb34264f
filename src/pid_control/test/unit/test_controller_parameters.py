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


def test_limits_must_be_in_order() -> None:
    with pytest.raises(ParameterError, match="output_min must be below output_max"):
        ControllerParameters(output_min=1.0)
