"""The declaration of the process node's parameters."""

import math

from basic_comms.conditioning.process_parameters import ProcessParameters


def test_defaults_and_ranges_are_as_specified() -> None:
    declared = ProcessParameters.declared
    assert {name: (item.default, item.range) for name, item in declared.items()} == {
        "amplitude_scale": (0.5, "[-1e6, 1e6]"),
        "phase_shift": (math.pi / 2.0, "[-1000, 1000]"),
        "offset": (0.0, "[-1e9, 1e9]"),
        "keep_positive": (True, ""),
        "method": ("sine", "{sine, delay}"),
        "input_offset": (0.0, "[-1e9, 1e9]"),
        "rate": (0.0, "[0, 10000]"),
    }
