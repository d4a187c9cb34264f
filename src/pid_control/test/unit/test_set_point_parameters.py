"""Tests of the set point's parameters."""

from basic_comms.signals.signal_parameters import SignalParameters
from pid_control.set_point_parameters import SetPointParameters


def test_they_are_a_signals_and_it_starts_by_itself() -> None:
    assert set(SetPointParameters.declared) == set(SignalParameters.declared) - {"autostart"}
    assert SetPointParameters(waveform="square").autostart is True
