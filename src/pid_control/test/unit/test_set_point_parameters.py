"""Tests of the set point's parameters."""

from basic_comms.signals.signal_parameters import SignalParameters
from pid_control.set_point_parameters import SetPointParameters


def test_set_point_parameters_are_those_of_a_signal_without_autostart() -> None:
    assert set(SetPointParameters.declared) == set(SignalParameters.declared) - {"autostart"}
    assert SetPointParameters(waveform="square").autostart is True
