# Pure: knows no ROS.
"""Gain, offset and stepped drawing of a page's traces.

The page receives scaled values only, so plot, measurements and trigger agree with the axis. CSV
files contain the original values.
"""

from typing import Any, Callable, Dict, Mapping, NamedTuple, Set, Tuple

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.protocol.checks import TRACES, RequestError, field_in, number_of

#: Returns the samples of a field from one time to another, both in s.
ReadSamples = Callable[[str, float, float], Samples]

_LARGEST = 1e300


class TraceScale(NamedTuple):
    """Scaling of one trace on a page.

    :param gain: factor of its values
    :param offset: added to the product
    :param steps: whether a value holds until the next sample
    """

    gain: float = 1.0
    offset: float = 0.0
    steps: bool = False


class Scaling(NamedTuple):
    """Scaling of all traces of a page.

    :param traces: by name of the field; other traces are not scaled
    """

    traces: Mapping[str, TraceScale] = {}

    def scaled(self, read: ReadSamples) -> ReadSamples:
        """Return a reader of scaled samples.

        :param read: returns the original samples
        """
        scales = {name: one for name, one in self.traces.items() if one[:2] != TraceScale()[:2]}
        if not scales:
            return read

        def samples(name: str, start: float, end: float) -> Samples:
            times, values = read(name, start, end)
            scale = scales.get(name)
            if scale is None:
                return times, values
            with numpy.errstate(over="ignore", invalid="ignore"):
                return times, values * scale.gain + scale.offset

        return samples

    def differing(self, other: "Scaling") -> Set[str]:
        """Return the names of the traces with other values under another scaling."""
        usual, names = TraceScale(), {*self.traces, *other.traces}
        both = {name: [one.traces.get(name, usual)[:2] for one in (self, other)] for name in names}
        return {name for name, (here, there) in both.items() if here != there}

    def is_stepped(self, name: str) -> bool:
        """Return whether a trace is drawn in steps."""
        scale = self.traces.get(name)
        return scale is not None and scale.steps


def scaling_of(request: Dict[str, Any]) -> Scaling:
    """Return the requested scaling of a page's traces.

    :param request: the received request
    :raises RequestError: if it is invalid
    """
    traces = request.get("traces")
    if not isinstance(traces, dict) or len(traces) > TRACES:
        raise RequestError(f"scaling: traces must be an object of at most {TRACES} fields")
    return Scaling(dict(_scale_of(name, wanted) for name, wanted in traces.items()))


def _scale_of(name: str, wanted: Any) -> Tuple[str, TraceScale]:
    field = field_in({"field": name}, "scaling")
    if not isinstance(wanted, dict) or not isinstance(wanted.get("steps", False), bool):
        raise RequestError(
            "scaling: a trace has a gain, an offset, and steps, which is true or false"
        )
    gain, offset = (
        number_of({key: wanted.get(key, usual)}, "scaling", key, -_LARGEST, _LARGEST)
        for key, usual in (("gain", 1.0), ("offset", 0.0))
    )
    return field, TraceScale(gain, offset, wanted.get("steps", False))
