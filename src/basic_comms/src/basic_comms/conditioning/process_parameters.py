"""Parameters of the process node."""

import math

from nodekit import BoolParameter, EnumParameter, FloatParameter, ParameterSet, RateParameter


class ProcessParameters(ParameterSet):
    """Parameters of the conditioning; all may change at any sample."""

    amplitude_scale = FloatParameter(
        0.5, minimum=-1e6, maximum=1e6, help="gain of the signal around the input offset"
    )
    phase_shift = FloatParameter(
        math.pi / 2.0,
        minimum=-1e3,
        maximum=1e3,
        unit="rad",
        help="lead of the output over the input",
    )
    offset = FloatParameter(0.0, minimum=-1e9, maximum=1e9, help="added to the output")
    keep_positive = BoolParameter(
        True, help="lift the output by as much as its negative peak lies below zero"
    )
    method = EnumParameter(
        "sine",
        choices=("sine", "delay"),
        help="how the phase is shifted: by the phase of a sine, or any shape by its last period",
    )
    input_offset = FloatParameter(
        0.0, minimum=-1e9, maximum=1e9, help="mean of the input, subtracted first"
    )
    rate = RateParameter(
        0.0,
        pausable=True,
        help="publish the latest output at this rate; 0 publishes at each sample",
    )
