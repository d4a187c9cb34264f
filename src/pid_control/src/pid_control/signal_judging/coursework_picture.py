"""SVG picture of a coursework: the signal, the output, and the fitted sines."""

from typing import List

from pid_control.charts.chart import Curve, Panel, as_svg
from pid_control.signal_judging.evidence import CourseworkEvidence
from pid_control.signal_judging.sine_fit import fit_sine

#: Colours that colour-blind readers can distinguish.
_SIGNAL, _OUTPUT, _SINE, _ZERO = "#0072b2", "#d55e00", "#888888", "#bbbbbb"


def as_picture(evidence: CourseworkEvidence, title: str) -> str:
    """Return the SVG picture; without a trial, only its title.

    :param evidence: evidence of the trials
    :param title: title of the picture
    """
    baseline, restart = evidence.baseline, evidence.restart
    if baseline is None or not baseline.signal.times:
        return as_svg([Panel(title, [Curve("nothing was received", _SIGNAL, [0.0], [0.0])])])
    signal, output = baseline.signal, baseline.output
    if restart is not None:
        signal, output = restart.signal, restart.output
    zero = signal.times[0]
    signals: List[Curve] = []
    sine = baseline.features.signal.sine
    times = [time - zero for time in baseline.signal.times]
    if sine is not None:
        fitted = [sine.at(time) for time in baseline.signal.times]
        signals.append(Curve("sine", _SINE, times, fitted))
    signals.append(
        Curve(signal.name, _SIGNAL, [time - zero for time in signal.times], signal.values)
    )
    outputs: List[Curve] = []
    finite = baseline.output.finite()
    if sine is not None:
        process = fit_sine(finite.times, finite.values, sine.frequency)
        if process is not None:
            shifted = [process.at(time) for time in finite.times]
            outputs.append(Curve("sine", _SINE, [time - zero for time in finite.times], shifted))
    if output.times:
        later = [time - zero for time in output.times]
        outputs.append(Curve("0", _ZERO, [later[0], later[-1]], [0.0, 0.0]))
        outputs.append(Curve(output.name, _OUTPUT, later, output.values, is_held=True))
    panels = [Panel(title, signals)]
    return as_svg([*panels, Panel("", outputs)] if outputs else panels)
