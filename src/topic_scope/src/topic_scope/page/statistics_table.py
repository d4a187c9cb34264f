"""JSON message to a page: measurements of its traces, and the latest states."""

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

#: Least silence of a trace that a page reports [s].
SILENT_S = 1.0


def statistics_of(
    recorder: Recorder,
    read: ReadSamples,
    view: LiveView,
    wanted: Measure,
    backoff: FrequencyBackoff,
    now: float,
) -> Dict[str, Any]:
    """Return the message with the measurements of a page's traces.

    :param recorder: recorder of the traces
    :param read: reader of their samples
    :param view: view of the page
    :param wanted: the requested measurements
    :param retries: traces that had no frequency
    :param now: the time [s]
    """
    span = wanted.span(now) or view.span(now)
    backoff.begin(span, now)
    traces = {
        name: _measured(recorder, read, name, span, wanted, backoff, now) for name in view.shown
    }
    traces.update((name, _state_of(recorder, name, now)) for name in view.states)
    return {"type": "stats", "traces": traces, "clocks": recorder.streams.clock_topics()}


def left_out(count: int, most: int) -> str:
    """Return the text about traces that are not shown because there are too many.

    :param count: number of traces
    :param most: most traces of a page
    """
    return f"a page shows at most {most} traces: the rest of {count} are left out"


def warn_of(recorder: Recorder, names: Sequence[str], most: int) -> None:
    """Log the problems of fields.

    :param recorder: recorder of the samples
    :param names: names of the fields
    :param most: most traces of a page
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
    result: Dict[str, Any] = {"problem": recorder.problem(name)}
    trace = recorder.trace(name)
    if trace is None:
        return result
    samples = read(name, *span)
    result.update(_origin_of(trace))
    result["jumps"] = trace.jumps
    if wanted.latency:
        late = trace.latency(*span)
        result["latency"] = float(numpy.median(late)) if len(late) else None
        result["latency_max"] = float(late.max()) if len(late) else None
    result.update(measure(*samples))
    known = backoff.known(name)
    found = waveform.measure_waveform(*samples, trace.longest_step, wanted.shapes, known)
    backoff.keep(name, found["frequency"])
    if wanted.against:
        reference, longest = read(wanted.against, *span), recorder.longest_step(wanted.against)
        found["phase"] = waveform.phase(samples, reference, longest)
    result.update({key: figure.value for key, figure in found.items()})
    result["uncertainty"] = {
        key: figure.uncertainty for key, figure in found.items() if figure.value is not None
    }
    result["unmeasurable"] = {key: figure.reason for key, figure in found.items() if figure.reason}
    if wanted.latency and trace.stream.no_latency:
        result["unmeasurable"]["latency"] = trace.stream.no_latency
    result["silent"] = _silence(trace, now)
    if not len(samples[0]) and result["silent"] is None and result["problem"] is None:
        result["problem"] = _why_empty(trace, span)
    return result


def _state_of(recorder: Recorder, name: str, now: float) -> Dict[str, Any]:
    """Return the latest state of a trace, without measurements."""
    result: Dict[str, Any] = {"problem": recorder.problem(name), "state": None}
    trace = recorder.trace(name)
    if trace is None or trace.states is None:
        return result
    numbers = trace.rows(to_ns(-math.inf), to_ns(now))[1]
    result["state"] = trace.states.text(float(numbers[-1])) if len(numbers) else None
    return {**result, **_origin_of(trace), "silent": _silence(trace, now)}


def _origin_of(trace: Recorded) -> Dict[str, Any]:
    stream = trace.stream
    origin = {"topic": stream.topic, "timestamp": stream.timestamp}
    leader = stream.leader.topic if stream.leader is not None else None
    return {**origin, "correction": trace.correction, "clock": leader}


def _silence(trace: Recorded, now: float) -> Optional[float]:
    """Return the time since the last message if it is unusually long [s]; otherwise None."""
    # By time of receipt: a trace with late stamps is not silent.
    quiet, usual = trace.silence(now), trace.longest_step
    silent = quiet is not None and quiet > max(usual if math.isfinite(usual) else 0.0, SILENT_S)
    return quiet if silent else None


def _why_empty(trace: Recorded, span: Tuple[float, float]) -> Optional[str]:
    """Return why a trace has no sample in a time span; None if it has no samples."""
    whole, start, end = trace.span, *span
    if whole is None:
        return None
    first, last = whole
    if last < start:
        return f"no sample in this span: the latest is {start - last:.3g} s before it"
    if first > end:
        return f"no sample in this span: the first is {first - end:.3g} s after it"
    return f"no sample in this span of {end - start:.3g} s: show a longer one"
