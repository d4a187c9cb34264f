"""A record of a plant: its inputs and its outputs."""

from typing import NamedTuple, Sequence, Tuple, Union

import numpy

Numbers = Union[Sequence[float], numpy.ndarray]
#: Fewest outputs of a usable record.
LEAST_OUTPUTS = 20
#: Message rate [Hz] above which an input is a stream, which ran before the record began.
_STREAM_HZ = 5.0


class IdentificationError(ValueError):
    """Error of a record that does not determine the plant; the text gives the reason."""


class Record(NamedTuple):
    """Sorted samples of a plant, in a time that starts at 0; see :func:`record_of`.

    :ivar changed_at: start time of each value of the input, ascending [s]
    :ivar inputs: the input from each of these times on
    :ivar times: times of the outputs, ascending from 0 [s]
    :ivar outputs: the outputs
    :ivar left_out: number of dropped values that were not finite
    """

    changed_at: numpy.ndarray
    inputs: numpy.ndarray
    times: numpy.ndarray
    outputs: numpy.ndarray
    left_out: int = 0

    @property
    def duration(self) -> float:
        """Time from the first output to the last [s]."""
        return float(self.times[-1] - self.times[0])

    @property
    def span(self) -> float:
        """Difference between the largest and the least output."""
        return float(numpy.ptp(self.outputs))

    @property
    def interval(self) -> float:
        """Median interval of the outputs [s]."""
        return float(numpy.median(numpy.diff(self.times)))

    def thinned(self, most: int) -> "Record":
        """Return a record with fewer outputs, evenly selected.

        :param most: largest number of outputs
        """
        every = -(-len(self.times) // most)
        return self._replace(times=self.times[::every], outputs=self.outputs[::every])

    def coarse(self, levels: int) -> "Record":
        """Return a record with a rounded input, which changes less often.

        :param levels: number of levels from 0 to the largest magnitude
        """
        unit = float(numpy.abs(self.inputs).max()) / levels
        inputs = numpy.round(self.inputs / unit) * unit
        changes = numpy.concatenate([[True], numpy.diff(inputs) != 0.0])
        return self._replace(changed_at=self.changed_at[changes], inputs=inputs[changes])


def record_of(
    input_times: Numbers, inputs: Numbers, output_times: Numbers, outputs: Numbers
) -> Record:
    """Make a record from samples; the input is held from one sample to the next.

    A sporadic input is 0 before its first message, like a motor's. If the input is a stream, the
    record begins with it.

    :param input_times: times of the inputs [s]
    :param inputs: the inputs
    :param output_times: times of the outputs [s]
    :param outputs: the outputs
    :raises IdentificationError: if the samples do not determine a plant
    """
    given_at, given = _in_order(input_times, inputs)
    times, measured = _in_order(output_times, outputs)
    left_out = len(inputs) + len(outputs) - len(given) - len(measured)
    if len(given) == 0:
        raise IdentificationError("the input is not in it")
    if len(times) < LEAST_OUTPUTS:
        raise IdentificationError(f"it has {len(times)} outputs; {LEAST_OUTPUTS} are the least")
    if times[-1] <= times[0]:
        raise IdentificationError(f"all outputs have the same time: {times[0]:g} s")
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
        raise IdentificationError("the input changes only outside the time of the outputs")
    if numpy.ptp(measured) == 0.0:
        raise IdentificationError(
            f"the output never changes: it is {measured[0]:g} throughout, while the input goes "
            f"from {given.min():g} to {given.max():g}"
        )
    # A float has too few digits for fractions of seconds since the epoch.
    begin = times[0]
    return Record(changed_at - begin, given, times - begin, measured, left_out)


def _in_order(times: Numbers, values: Numbers) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the finite samples, sorted by time."""
    samples = numpy.array([times, values], float)
    samples = samples[:, numpy.isfinite(samples).all(axis=0)]
    ordered: numpy.ndarray = samples[:, numpy.argsort(samples[0], kind="stable")]
    return ordered[0], ordered[1]
