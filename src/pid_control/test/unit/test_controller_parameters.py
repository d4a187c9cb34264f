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


def test_each_parameter_has_its_default_range_and_unit() -> None:
    gain = "[-1e6, 1e6]"
    found = {
        name: (one.default, getattr(one, "range", ""), one.unit)
        for name, one in ControllerParameters.declared.items()
    }
    assert found == {
        "mode": ("PI", "{manual, P, PI, PID}", ""),
        "enabled": (True, "", ""),
        "kp": (0.08, gain, ""),
        "ki": (1.5, gain, "1/s"),
        "kd": (0.0, gain, "s"),
        "filter_time": (0.01, "[0, 1000]", "s"),
        "set_point_weight": (1.0, "[0, 1]", ""),
        "feed_forward": (0.0, gain, ""),
        "output_min": (-1.0, gain, ""),
        "output_max": (1.0, gain, ""),
        "dead_zone": (0.0, "[0, 1e6]", ""),
        "anti_windup": ("clamping", "{clamping, back_calculation, none}", ""),
        "tracking_time": (0.1, "(0, 1000]", "s"),
        "manual_output": (0.0, gain, ""),
        "timeout": (0.5, "[0.01, 60]", "s"),
        "command_timeout": (1.0, "[0, 1e6]", "s"),
    }


def test_limits_must_be_in_order() -> None:
    with pytest.raises(ParameterError, match="output_min must be below output_max"):
        ControllerParameters(output_min=1.0)
    with pytest.raises(ParameterError, match="output_min must be below output_max"):
        ControllerParameters(output_max=-1.5)
