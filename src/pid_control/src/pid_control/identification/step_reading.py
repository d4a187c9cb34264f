"""Gain K and time constant T (time to 63.2 %) from one step response, read as by hand."""

from typing import List, NamedTuple, Optional

import numpy

from pid_control.identification.fit import Identification
from pid_control.identification.record import Record

#: Share of a step response that is complete after one time constant.
_SHARE = 1.0 - float(numpy.exp(-1.0))
#: Shortest step that is read, as a share of the longest.
_LONG = 0.3
#: Outputs that count as steady: the last share of the time before the input changes.
_STEADY = 0.1
#: Time constants until a response is steady.
_SETTLED = 5.0
#: Differences that matter: of times as a share of T, of outputs as a share of the step, and of K or
#: T as a share of itself.
_OF_TIME, _OF_STEP, _ALIKE = 0.02, 0.02, 0.03


class StepReading(NamedTuple):
    """K and T of one step.

    :ivar time: time of the step [s]
    :ivar before: input before the step
    :ivar after: input after the step
    :ivar duration: time until the next change of the input [s]
    :ivar gain: K
    :ivar time_constant: T [s]
    """

    time: float
    before: float
    after: float
    duration: float
    gain: float
    time_constant: float


def read_step(record: Record) -> Optional[StepReading]:
    """Read K and T from the largest of the longest steps, as on paper with a ruler.

    :param record: a record of the plant
    :returns: None if no step is followed by enough outputs
    """
    ends = numpy.append(record.changed_at[1:], record.times[-1])
    holds = (ends - record.changed_at)[1:]
    steps = numpy.where(holds > _LONG * holds.max(), numpy.abs(numpy.diff(record.inputs)), 0.0)
    index = int(numpy.argmax(steps)) + 1
    begin, time, end = record.changed_at[index - 1], record.changed_at[index], ends[index]
    rest = record.outputs[_between(record, time - _STEADY * (time - begin), time)]
    steady = record.outputs[_between(record, end - _STEADY * (end - time), end)]
    if len(rest) == 0 or len(steady) == 0:
        return None
    low, high = float(rest.mean()), float(steady.mean())
    response = _between(record, time, end)
    done = (record.outputs[response] - low) * (1.0 if high >= low else -1.0)
    reached = numpy.flatnonzero(done >= _SHARE * abs(high - low))
    if high == low or len(reached) == 0:
        return None
    before, after = float(record.inputs[index - 1]), float(record.inputs[index])
    passed = float(record.times[response][reached[0]] - time)
    return StepReading(
        float(time), before, after, float(end - time), (high - low) / (after - before), passed
    )


def _between(record: Record, begin: float, end: float) -> numpy.ndarray:
    is_between: numpy.ndarray = (record.times >= begin) & (record.times < end)
    return is_between


def why_they_differ(record: Record, found: Identification, reading: StepReading) -> List[str]:
    """Return a sentence for each reason why a step reading differs from the least-squares fit.

    :param record: a record of the plant
    :param found: the least-squares fit
    :param reading: the step reading
    """
    model = found.model
    step = abs(model.gain * (reading.after - reading.before))
    causes: List[str] = []
    if max(abs(model.gain * reading.after), abs(model.gain * reading.before)) > model.limit:
        causes.append(
            f"the output meets its limit of {model.limit:.4g}, which is read as if it were steady"
        )
    for value in (reading.before, reading.after):
        if 0.0 < abs(value) <= model.dead_zone:
            causes.append(f"an input of {value:g} is in the dead zone, and acts as 0")
    if model.friction:
        causes.append(f"the friction takes {model.friction:.3g} of the input, which is read into K")
    if model.dead_time > _OF_TIME * model.time_constant:
        causes.append(f"the dead time of {model.dead_time:.3g} s is read as a part of T")
    if model.dead_time < -_OF_TIME * model.time_constant:
        causes.append("the input was recorded late, and T is read from then on")
    ratio = (reading.duration - model.dead_time) / model.time_constant
    if ratio < _SETTLED:
        causes.append(f"the step holds for {max(ratio, 0.0):.1f} T: the output is not steady yet")
    if found.residual > _OF_STEP * step:
        causes.append("with noise, the first output beyond 63.2 % is too early")
    if record.interval > _OF_TIME * model.time_constant:
        causes.append(
            f"the outputs are {record.interval:.3g} s apart, which limits the reading of T"
        )
    off = max(
        abs(reading.gain / model.gain - 1.0),
        abs(reading.time_constant / model.time_constant - 1.0),
    )
    if off <= _ALIKE:
        return ["they agree"]
    return causes or ["the plant is not quite of first order"]
