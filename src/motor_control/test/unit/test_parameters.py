"""Parameter declarations of motor and set point."""

import math

import pytest

from basic_comms.signals.signal_parameters import WAVEFORMS, SignalParameters
from basic_comms.signals.signal_source import SignalSource
from first_order_sys_sim.first_order_plant import FirstOrderPlant
from motor_control.motor_parameters import MotorParameters
from motor_control.nodes.set_point import SetPointParameters
from nodekit import ParameterError


def test_motor_has_the_courses_values() -> None:
    assert MotorParameters().as_dict() == {
        "sample_time": 0.02,
        "sys_gain_K": 1.75,
        "sys_tau_T": 0.5,
        "initial_conditions": 0.0,
    }


@pytest.mark.parametrize(
    "name, value", [("sys_gain_K", -0.1), ("sys_tau_T", -0.5), ("sys_tau_T", 0), ("sample_time", 0)]
)
def test_motor_rejects_invalid_values(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        MotorParameters(**{name: value})


def test_motor_is_the_plant_that_its_parameters_say() -> None:
    plant = FirstOrderPlant(MotorParameters(sys_gain_K=4.0, sys_tau_T=0.9).plant)
    plant.hold(0.0, 2.0)
    assert plant.output(0.9) == pytest.approx(8.0 * (1.0 - math.exp(-1.0)), abs=1e-12)


def test_speed_of_the_strongest_motor_fits_into_a_message() -> None:
    plant = FirstOrderPlant(MotorParameters(sys_gain_K=1e6).plant)
    plant.hold(0.0, 3.4e38)
    assert plant.output(100.0) == 3.4028234663852886e38


def test_set_point_is_a_sine_of_the_courses_values() -> None:
    source, settings = SignalSource(), SetPointParameters()
    for time in (0.0, 0.1, 1.0, 100.0):
        value = source.sample(time, settings).value
        assert value == pytest.approx(2.0 * math.sin(time), abs=1e-12)
    assert (settings.rate, settings.amplitude, settings.omega) == (10.0, 2.0, 1.0)


def test_set_point_follows_omega() -> None:
    source, settings = SignalSource(), SetPointParameters(omega=3.0, phase=0.5)
    assert source.sample(0.7, settings).value == pytest.approx(2.0 * math.sin(2.6), abs=1e-12)
    assert SetPointParameters().replace(omega=-2.0).frequency == -2.0


@pytest.mark.parametrize("waveform", WAVEFORMS)
def test_set_point_knows_every_waveform(waveform: str) -> None:
    if waveform == "file":
        with pytest.raises(ParameterError):
            SetPointParameters(waveform=waveform)  # it asks for the file, as the signal does
        return
    source, same = SignalSource(), SignalSource()
    for time in (0.0, 0.3, 1.1):
        got = source.sample(time, SetPointParameters(waveform=waveform, omega=2.5))
        assert got == same.sample(time, SignalParameters(waveform=waveform, frequency=2.5))


def test_set_point_declares_signal_parameters_except_two() -> None:
    assert set(SetPointParameters.declared) ^ set(SignalParameters.declared) == {
        "omega",
        "frequency",
        "autostart",
    }
    assert SetPointParameters.declared["omega"].name == "omega"
    assert SignalParameters.declared["frequency"].name == "frequency"
    assert SignalParameters().frequency == 2.0 * math.pi
