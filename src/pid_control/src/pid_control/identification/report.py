"""Report of an identification, as text and as a picture."""

import math
from typing import List, Optional

from pid_control.charts.chart import Curve, Panel, as_svg
from pid_control.identification.fit import Identification
from pid_control.identification.record import Record
from pid_control.identification.step_reading import StepReading, why_they_differ

#: Colours that colour-blind readers can distinguish.
_RECORD, _MODEL, _INPUT = "#999999", "#0072b2", "#d55e00"


def as_text(record: Record, found: Identification, reading: Optional[StepReading]) -> str:
    """Return the table of results.

    :param record: a record of the plant
    :param found: the least-squares fit
    :param reading: the step reading, if any
    """
    model, uncertainty = found.model, found.uncertainty
    read = ("", "") if reading is None else (reading.gain, reading.time_constant)
    lines = [
        f"{record.duration:.3g} s, {len(record.times)} outputs, "
        f"{len(record.inputs) - 1} changes of the input",
        f"{'':12}{'least squares':28}63.2 % reading",
        _line("K", model.gain, uncertainty.gain, "", read[0]),
        _line("T", model.time_constant, uncertainty.time_constant, " s", read[1]),
        _line("dead time", model.dead_time, uncertainty.dead_time, " s"),
        _line("dead zone", model.dead_zone, uncertainty.dead_zone, "")
        if model.dead_zone
        else f"{'dead zone':12}not found",
        _line("limit", model.limit, uncertainty.limit, "")
        if math.isfinite(model.limit)
        else f"{'limit':12}not met",
        _line("offset", model.offset, uncertainty.offset, "")
        if model.offset
        else f"{'offset':12}not found",
        _line("friction", model.friction, uncertainty.friction, "")
        if model.friction
        else f"{'friction':12}not found",
        f"{'residual':12}{found.residual:.3g} rms, {100.0 * found.residual / record.span:.2g} % of "
        f"the outputs' range",
    ]
    lines += [f"± {sentence}" for sentence in trust_in(found)]
    if record.left_out:
        lines.append(f"{'left out':12}{record.left_out} values that are not finite")
    if reading is None:
        lines.append("No step in it is followed by enough outputs for a 63.2 % reading.")
    else:
        lines.append(
            f"The reading is of the step from {reading.before:.3g} to {reading.after:.3g} at "
            f"{reading.time:.3g} s:"
        )
        lines += [f"- {why}" for why in why_they_differ(record, found, reading)]
    if model.dead_time < -uncertainty.dead_time:
        lines.append(
            "The output begins before its input, which was recorded late by "
            f"{-model.dead_time:.2g} s or more: the dead time is unknown."
        )
    return "\n".join(lines)


def trust_in(found: Identification) -> List[str]:
    """Return sentences on whether the uncertainty holds, each to follow its sign.

    :param found: the least-squares fit
    """
    test = found.test
    doubts = []
    if test.follows_input:
        doubts.append("the residual follows the input, so the model lacks a term")
    if not test.is_noise:
        doubts.append("the residual is not noise")
    if not test.can_tell:
        doubts.append(f"the record has only {test.independent:.0f} independent outputs")
    sentences = [f"does not hold in 95 of 100: {why}" for why in doubts]
    if not sentences:
        sentences.append("holds in 95 of 100: the residual is noise, whatever the input")
    if not test.is_white:
        sentences.append(
            f"counts {test.independent:.0f} independent outputs: the residual is autocorrelated"
        )
    return sentences


def _line(name: str, value: float, uncertainty: float, unit: str, read: object = "") -> str:
    text = f"{value:.5g} ± {uncertainty:.2g}{unit}"
    shown = f"{read:.4g}{unit}" if isinstance(read, float) else ""
    return f"{name:12}{text:28}{shown}".rstrip()


def as_picture(record: Record, found: Identification) -> str:
    """Return an SVG picture of record and fit, the residual and the input.

    :param record: a record of the plant
    :param found: the least-squares fit
    """
    times: List[float] = record.times.tolist()
    # The last input holds until the end.
    changes = [*record.changed_at.tolist(), times[-1]]
    inputs = [*record.inputs.tolist(), float(record.inputs[-1])]
    curves = [
        Curve("record", _RECORD, times, record.outputs.tolist()),
        Curve("model", _MODEL, times, found.fitted.tolist()),
    ]
    if found.model.offset:
        ends, level = [times[0], times[-1]], found.model.offset
        curves.append(Curve(f"offset {level:.4g}", _INPUT, ends, [level, level]))
    friction = f" (friction {found.model.friction:.3g})" if found.model.friction else ""
    doubt = "" if found.test.fits else ": ± does not hold in 95 of 100"
    return as_svg(
        [
            Panel("output", curves),
            Panel(
                "residual" + doubt,
                [Curve("", _RECORD, times, (record.outputs - found.fitted).tolist())],
                80.0,
            ),
            Panel("input" + friction, [Curve("", _INPUT, changes, inputs, True)], 80.0),
        ]
    )
