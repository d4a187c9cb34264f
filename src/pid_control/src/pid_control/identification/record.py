"""A record of a plant: what it was given, and what it did."""

from typing import NamedTuple, Sequence, Tuple, Union

import numpy

Numbers = Union[Sequence[float], numpy.ndarray]
#: Fewer outputs than this do not make a record.
LEAST_OUTPUTS = 20
#: An input with more messages than this, 1/s, is a stream, which was there before the record began.
_STREAM_HZ = 5.0


class IdentificationError(ValueError):
    """A record that cannot tell what the plant is like; the text says why."""


class Record(NamedTuple):
    """A record that is in order, in a time of its own; see :func:`record_of`.

    :ivar changed_at: when the input changed, ascending, s; the first is what it was at first
    :ivar inputs: what it was from then on
    :ivar times: when the output was measured, ascending, from 0 on, s
    :ivar outputs: what it was
    :ivar left_out: how many values were left out as they were not finite
    """

    changed_at: numpy.ndarray
    inputs: numpy.ndarray
    times: numpy.ndarray
    outputs: numpy.ndarray
    left_out: int = 0

    @property
    def duration(self) -> float:
        """From the first output to the last, s."""
        return float(self.times[-1] - self.times[0])

    @property
    def span(self) -> float:
        """How far the outputs lie apart."""
        return float(numpy.ptp(self.outputs))

    @property
    def interval(self) -> float:
        """The usual time from one output to the next, s."""
        return float(numpy.median(numpy.diff(self.times)))

    def thinned(self, most: int) -> "Record":
        """Return a record with fewer outputs, evenly chosen.

        :param most: how many are left at most
        """
        every = -(-len(self.times) // most)
        return self._replace(times=self.times[::every], outputs=self.outputs[::every])

    def coarse(self, levels: int) -> "Record":
        """Return a record whose input is rounded, so that it changes less often.

        :param levels: as many values it has from 0 to its largest magnitude
        """
        unit = float(numpy.abs(self.inputs).max()) / levels
        inputs = numpy.round(self.inputs / unit) * unit
        changes = numpy.concatenate([[True], numpy.diff(inputs) != 0.0])
        return self._replace(changed_at=self.changed_at[changes], inputs=inputs[changes])


def record_of(
    input_times: Numbers, inputs: Numbers, output_times: Numbers, outputs: Numbers
) -> Record:
    """Make a record of samples; the input is held from one to the next.

    Where an input comes now and then, it is 0 before its first message, as a motor's is. Where it
    is a stream, the record begins with it.

    :param input_times: when inputs were given, s
    :param inputs: what they were
    :param output_times: when outputs were measured, s
    :param outputs: what they were
    :raises IdentificationError: if nothing can be learnt from them
    """
    given_at, given = _in_order(input_times, inputs)
    times, measured = _in_order(output_times, outputs)
    left_out = len(inputs) + len(outputs) - len(given) - len(measured)
    if len(given) == 0:
        raise IdentificationError("the input is not in it")
    if len(times) < LEAST_OUTPUTS:
        raise IdentificationError(f"it has {len(times)} outputs; {LEAST_OUTPUTS} are the least")
    if given_at[0] > times[0]:
        if len(given) > 1 and numpy.median(numpy.diff(given_at)) < 1.0 / _STREAM_HZ:
            is_within = times >= given_at[0]
            times, measured = times[is_within], measured[is_within]
        else:
            given_at = numpy.concatenate([times[:1], given_at])
            given = numpy.concatenate([[0.0], given])
    changes = numpy.concatenate([[True], numpy.diff(given) != 0.0])
    changed_at, given = given_at[changes], given[changes]
    if len(given) == 1:
        raise IdentificationError(f"the input never changes: it is {given[0]:g} throughout")
    if len(times) < LEAST_OUTPUTS or changed_at[1] >= times[-1]:
        raise IdentificationError("the input changes only where there are no outputs")
    if numpy.ptp(measured) == 0.0:
        raise IdentificationError(
            f"the output never changes: it is {measured[0]:g} throughout, while the input goes "
            f"from {given.min():g} to {given.max():g}"
        )
    # Of seconds since the epoch a float does not keep enough digits.
    begin = times[0]
    return Record(changed_at - begin, given, times - begin, measured, left_out)


def _in_order(times: Numbers, values: Numbers) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return samples in the order of their times, without those that are not finite."""
    samples = numpy.array([times, values], float)
    samples = samples[:, numpy.isfinite(samples).all(axis=0)]
    ordered: numpy.ndarray = samples[:, numpy.argsort(samples[0], kind="stable")]
    return ordered[0], ordered[1]
