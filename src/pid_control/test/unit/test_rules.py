"""Tests of the tuning rules against their publications."""

import pytest
import yaml

from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.identification.response import Model
from pid_control.tuning.rules import LAMBDA, METHODS, SIMC, ZN_PI, ZN_PID, as_yaml, gains_of

#: theta is 0.5 s with half of a period of 0.2 s.
MODEL, PERIOD = Model(2.0, 4.0, 0.4), 0.2


def test_each_rule() -> None:
    found = gains_of(MODEL, PERIOD)
    assert found[SIMC][2:5] == pytest.approx(("PI", 2.0, 0.5), rel=1e-12)
    assert found[LAMBDA].kp == pytest.approx(4.0 / 9.0)
    assert found[LAMBDA].ki == pytest.approx(1.0 / 9.0)
    assert found[ZN_PI].kp == pytest.approx(3.6)
    assert found[ZN_PI].ki == pytest.approx(3.6 * 0.3 / 0.5)
    assert found[ZN_PID].kp == pytest.approx(4.8)
    assert found[ZN_PID].ki == pytest.approx(4.8)
    assert found[ZN_PID].kd == pytest.approx(1.2)
    assert found[ZN_PID].filter_time == pytest.approx(0.025)
    assert [found[method].mode for method in METHODS] == ["PI", "PI", "PI", "PID"]
    named = {method: as_yaml(found[method], "a", -1.0, 1.0).splitlines()[0] for method in METHODS}
    for method, source in ((SIMC, "Skogestad"), (LAMBDA, "Dahlin"), (ZN_PI, "Ziegler")):
        assert named[method].startswith(f"# {method} ({source}"), named
    assert "(Ziegler" in named[ZN_PID]


def test_simc_short_time_constant_is_the_integral_time() -> None:
    found = gains_of(MODEL._replace(time_constant=1.0), PERIOD)
    assert found[SIMC].kp / found[SIMC].ki == pytest.approx(1.0)


def test_wanted_time_constant_changes_simc_and_lambda_only() -> None:
    found, wanted = gains_of(MODEL, PERIOD), gains_of(MODEL, PERIOD, 1.5)
    assert wanted[SIMC].kp == wanted[LAMBDA].kp == pytest.approx(1.0)
    assert wanted[ZN_PI] == found[ZN_PI]
    tight = gains_of(MODEL, PERIOD, 0.25)
    times = [tight[method].kp / tight[method].ki for method in (SIMC, LAMBDA)]
    assert times == pytest.approx([3.0, 4.0])


def test_negative_plant_gain_negates_all_gains() -> None:
    found = gains_of(MODEL._replace(gain=-2.0), PERIOD)
    assert found
    for gains in found.values():
        assert gains.kp < 0.0 and gains.ki < 0.0 and gains.kd <= 0.0


@pytest.mark.parametrize("gain", [2.0, 1e-4, 3e7])
@pytest.mark.parametrize("method", METHODS)
def test_yaml_is_valid_for_the_controller(method: str, gain: float) -> None:
    gains = gains_of(MODEL._replace(gain=gain), PERIOD)[method]
    held = yaml.safe_load(as_yaml(gains, "a\nmodel", -0.5, 0.8))
    values = ControllerParameters(**held)
    assert values.mode == gains.mode
    for name in ("kp", "ki", "kd", "filter_time"):
        assert getattr(values, name) == pytest.approx(getattr(gains, name), rel=1e-3), name
    assert (values.output_min, values.output_max) == (-0.5, 0.8)
