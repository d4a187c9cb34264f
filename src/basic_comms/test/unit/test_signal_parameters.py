"""Which values of the signal generator's parameters go together, and which file is taken."""

import math
from typing import Any, Dict

import pytest

from basic_comms.signals.signal_parameters import SignalParameters
from nodekit import ParameterError

TWO_PI = 2.0 * math.pi
#: Defaults and ranges by name, which launch files, bags and reports of many courses rely on.
NUMBERS: Dict[str, Any] = {
    "rate": (10.0, "[1e-06, 10000]"),
    "amplitude": (2.0, "[0, 1e9]"),
    "frequency": (TWO_PI, "[-1e6, 1e6]"),
    "phase": (0.0, "[-1e6, 1e6]"),
    "offset": (0.0, "[-1e9, 1e9]"),
    "duty": (0.5, "(0, 1)"),
    "symmetry": (1.0, "[0, 1]"),
    "step_time": (1.0, "[0, 1e9]"),
    "slope": (1.0, "[-1e9, 1e9]"),
    "chirp_f0": (0.1 * TWO_PI, "[-1e6, 1e6]"),
    "chirp_f1": (TWO_PI, "[-1e6, 1e6]"),
    "chirp_duration": (10.0, "(0, 1e9]"),
    "seed": (0, "[0, 2147483647]"),
    "prbs_order": (7, "[2, 31]"),
    "chip_time": (0.1, "[0.0001, 1e9]"),
    "multisine_amplitudes": ((1.0, 0.5), "1 to 1000 of [-1e9, 1e9]"),
    "multisine_frequencies": ((TWO_PI, 2.0 * TWO_PI), "1 to 1000 of [-1e6, 1e6]"),
    "multisine_phases": ((0.0, 0.0), "1 to 1000 of [-1e6, 1e6]"),
    "start_delay": (0.0, "[0, 1e9]"),
    "duration": (0.0, "[0, 1e9]"),
    "stop_value": (0.0, "[-1e9, 1e9]"),
}
SWITCHES = {"chirp_repeat": False, "file_loop": False, "autostart": True}

LOGARITHMIC = "a logarithmic chirp must have two frequencies above 0 that differ"


def test_defaults_and_ranges_are_as_specified() -> None:
    declared = SignalParameters.declared
    assert {name: (declared[name].default, declared[name].range) for name in NUMBERS} == NUMBERS
    assert {name: declared[name].default for name in SWITCHES} == SWITCHES
    words = {"waveform", "chirp_shape", "file", "file_mode"}
    assert set(declared) == {*NUMBERS, *SWITCHES, *words}


def multisine(*lengths: int) -> Dict[str, Any]:
    """Return sequences of these lengths."""
    names = ("multisine_amplitudes", "multisine_frequencies", "multisine_phases")
    return {name: (1.0,) * length for name, length in zip(names, lengths)}


@pytest.mark.parametrize(
    "values, words",
    [
        ({"chirp_shape": "logarithmic", "chirp_f0": 0.0, "chirp_f1": 1.0}, LOGARITHMIC),
        ({"chirp_shape": "logarithmic", "chirp_f0": 1.0, "chirp_f1": 0.0}, LOGARITHMIC),
        ({"chirp_shape": "logarithmic", "chirp_f0": -1.0, "chirp_f1": -2.0}, LOGARITHMIC),
        ({"chirp_shape": "logarithmic", "chirp_f0": 3.0, "chirp_f1": 3.0}, LOGARITHMIC),
        (multisine(3, 2, 2), "the three lists must have one length"),
        (multisine(2, 3, 2), "the three lists must have one length"),
        (multisine(2, 2, 1), "the three lists must have one length"),
        ({"multisine_amplitudes": [0.0, 0.0]}, "at least one amplitude must be other than 0"),
        ({"waveform": "file"}, "waveform 'file' must have a CSV file of time,value"),
        ({"waveform": "file", "file": ""}, "waveform 'file' must have a CSV file of time,value"),
    ],
)
def test_values_that_do_not_go_together_are_refused(values: Dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError) as refusal:
        SignalParameters(**values)
    assert str(refusal.value).endswith(words)
    assert all(name in str(refusal.value) for name in values)


@pytest.mark.parametrize(
    "values",
    [
        {"chirp_shape": "logarithmic", "chirp_f0": 2.0, "chirp_f1": 1.0},
        {"chirp_shape": "linear", "chirp_f0": -1.0, "chirp_f1": 0.0},
        {"chirp_shape": "linear", "chirp_f0": 1.0, "chirp_f1": 1.0},
        multisine(3, 3, 3),
        {"multisine_amplitudes": (0.0, -1.0)},
    ],
)
def test_values_that_go_together_are_taken(values: Dict[str, Any]) -> None:
    taken = SignalParameters(**values).as_dict()
    assert {name: taken[name] for name in values} == values


def test_a_file_is_read_when_its_path_is_set(tmp_path: Any) -> None:
    path = str(tmp_path / "series.csv")
    with open(path, "w") as file:
        file.write("0,1\n2,3\n")
    for waveform in ("file", "sine"):
        series = SignalParameters(waveform=waveform, file=path).series
        assert series is not None and len(series) == 2
    assert SignalParameters().series is None


def test_invalid_path_is_rejected_with_message(tmp_path: Any, monkeypatch: Any) -> None:
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError) as refusal:
        SignalParameters(file="folder")
    assert str(refusal.value).startswith(
        "parameter file: refused 'folder': must be the path of a CSV file of time,value or empty "
    )
    assert "this is a folder; a CSV file of time,value is needed" in str(refusal.value)
