"""Statistics of a page's traces, as its table shows them."""

import math
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy
import rospy

from topic_scope.analysis import waveform
from topic_scope.analysis.statistics import measure
from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.view import LiveView
from topic_scope.protocol.requests import Measure
from topic_scope.protocol.scaling import ReadSamples
from topic_scope.sampling.computed_trace import Recorded
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import to_ns

#: Least time without a sample after which a page says so [s].
SILENT_S = 1.0


def statistics_of(
    recorder: Recorder,
    read: ReadSamples,
    view: LiveView,
    wanted: Measure,
    backoff: FrequencyBackoff,
    now: float,
) -> Dict[str, Any]:
    """Return the message that tells a page what is measured of its traces.

    :param recorder: knows the traces
    :param read: returns their samples
    :param view: what the page shows
    :param wanted: what it wants to be measured
    :param retries: knows what had no frequency
    :param now: the time [s]
    """
    span = wanted.span(now) or view.span(now)
    backoff.begin(span, now)
    traces = {
        name: _measured(recorder, read, name, span, wanted, backoff, now) for name in view.shown
    }
    traces.update((name, _state_of(recorder, name, now)) for name in view.states)
    return {"type": "stats", "traces": traces}


def left_out(count: int, most: int) -> str:
    """Return the sentence about traces that are not shown, as there are too many.

    :param count: how many there are
    :param most: how many a page shows
    """
    return f"a page shows at most {most} traces: the rest of {count} are left out"


def warn_of(recorder: Recorder, names: Sequence[str], most: int) -> None:
    """Log the problems of fields.

    :param recorder: has the samples
    :param names: of the fields
    :param most: how many a page shows
    """
    for name in names[:most]:
        problem = recorder.problem(name)
        if problem is not None:
            rospy.logwarn(f"{name}: {problem}")
    if len(names) > most:
        rospy.logwarn(left_out(len(names), most))


def _measured(
    recorder: Recorder,
    read: ReadSamples,
    name: str,
    span: Tuple[float, float],
    wanted: Measure,
    backoff: FrequencyBackoff,
    now: float,
) -> Dict[str, Any]:
    told: Dict[str, Any] = {"problem": recorder.problem(name)}
    trace = recorder.trace(name)
    if trace is None:
        return told
    samples = read(name, *span)
    told.update(_origin_of(trace))
    told["jumps"] = trace.jumps
    if wanted.latency:
        late = trace.latency(*span)
        told["latency"] = float(numpy.median(late)) if len(late) else None
        told["latency_max"] = float(late.max()) if len(late) else None
    told.update(measure(*samples))
    known = backoff.known(name)
    found = waveform.measure_waveform(*samples, trace.longest_step, wanted.shapes, known)
    backoff.keep(name, found["frequency"])
    if wanted.against:
        reference, longest = read(wanted.against, *span), recorder.longest_step(wanted.against)
        found["phase"] = waveform.phase(samples, reference, longest)
    told.update({key: figure.value for key, figure in found.items()})
    told["uncertainty"] = {
        key: figure.uncertainty for key, figure in found.items() if figure.value is not None
    }
    told["unmeasurable"] = {key: figure.reason for key, figure in found.items() if figure.reason}
    if wanted.latency and trace.stream.no_latency:
        told["unmeasurable"]["latency"] = trace.stream.no_latency
    told["silent"] = _silence(trace, now)
    if not len(samples[0]) and told["silent"] is None and told["problem"] is None:
        told["problem"] = _why_empty(trace, span)
    return told


def _state_of(recorder: Recorder, name: str, now: float) -> Dict[str, Any]:
    """Return what is told of a state: the latest one, and no figures."""
    told: Dict[str, Any] = {"problem": recorder.problem(name), "state": None}
    trace = recorder.trace(name)
    if trace is None or trace.states is None:
        return told
    numbers = trace.rows(to_ns(-math.inf), to_ns(now))[1]
    told["state"] = trace.states.text(float(numbers[-1])) if len(numbers) else None
    return {**told, **_origin_of(trace), "silent": _silence(trace, now)}


def _origin_of(trace: Recorded) -> Dict[str, Any]:
    stream = trace.stream
    origin = {"topic": stream.topic, "timestamp": stream.timestamp}
    return {**origin, "correction": trace.correction}


def _silence(trace: Recorded, now: float) -> Optional[float]:
    """Return for how long nothing has come where that is unusual [s]; else None."""
    # By reception: what is late is not silent.
    quiet, usual = trace.silence(now), trace.longest_step
    silent = quiet is not None and quiet > max(usual if math.isfinite(usual) else 0.0, SILENT_S)
    return quiet if silent else None


def _why_empty(trace: Recorded, span: Tuple[float, float]) -> Optional[str]:
    """Return why a trace has no sample in a span of time; None if it has none at all."""
    whole, start, end = trace.span, *span
    if whole is None:
        return None
    first, last = whole
    if last < start:
        return f"no sample in this span: the latest is {start - last:.3g} s before it"
    if first > end:
        return f"no sample in this span: the first is {first - end:.3g} s after it"
    return f"no sample in this span of {end - start:.3g} s: show a longer one"
