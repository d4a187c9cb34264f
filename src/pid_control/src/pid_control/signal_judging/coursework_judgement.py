"""Judgement of a coursework by its evidence: the failures, and the cause of each."""

import math
from typing import Callable, Dict, List, Mapping, Sequence, Tuple

from pid_control.signal_judging.channels import Channel, oscillates
from pid_control.signal_judging.evidence import (
    GENERATOR,
    PROCESS,
    BaselineTrial,
    CourseworkEvidence,
    FailedTrial,
)
from pid_control.signal_judging.metric_values import Figures, figures_of, frequencies_of, is_known
from pid_control.signal_judging.parameter_roles import GENERATOR_ROLES, role_of
from pid_control.signal_judging.scenarios import METRICS
from pid_control.verdicts.judgement import (
    FAILED,
    NOT_JUDGED,
    PASSED,
    Cause,
    Failure,
    Finding,
    Judgement,
    found,
    number,
    text_of,
)
from pid_control.verdicts.limits import Limits

#: Flaws, worst first: each may be the reason of those after it.
FLAWS = (
    "crash",
    "flood",
    "endless output",
    "not connected",
    "launch",
    "silent",
    "constant",
    "too seldom",
    "nan",
    "undersampled",
    "distorted",
    "amplitude",
    "frequency",
    "fields",
    "free-running",
    "unchanged",
    "phase",
    "negative",
    "restart",
    "hard-coded",
    "unread",
    "yaml",
    "namespace",
)
#: Scenarios that a failed trial leaves without figures.
_ENDS = {"signal": ("signal", "process", "restart", "parameters", "yaml", "namespace")}


def judge(
    evidence: CourseworkEvidence, limits: Limits, scenarios: Sequence[str], reason: str = ""
) -> Judgement:
    """Judge a coursework.

    :param evidence: evidence of its trials
    :param limits: limits of the figures
    :param scenarios: names of the scenarios to judge
    :param reason: why not all trials were run, if so
    """
    figures = figures_of(evidence)
    findings: List[Finding] = []
    failures: List[Failure] = []
    for scenario, broken in evidence.broken.items():
        failures.append(Failure(scenario, broken.flaw, _cause_of_broken(broken)))
    for scenario in scenarios:
        for name, metric in METRICS[scenario].items():
            if (scenario, name) not in figures:
                continue
            value = figures[scenario, name]
            finding = found(
                scenario, name, value, limits, metric.label, metric.unit, metric.is_least
            )
            findings.append(finding)
            if not finding.passed:
                cause = _CAUSES[scenario, name](evidence, figures)
                failures.append(Failure(scenario, text_of(finding), cause))
    failures.sort(key=lambda failure: FLAWS.index(failure.cause.flaw))
    if failures:
        return Judgement(FAILED, findings, failures)
    reason = reason or _unknown(evidence, scenarios)
    if reason or not findings:
        return Judgement(NOT_JUDGED, findings, failures, reason or "nothing was measured")
    return Judgement(PASSED, findings, failures)


def _unknown(evidence: CourseworkEvidence, scenarios: Sequence[str]) -> str:
    """Return why the signal is unknown, or an empty text."""
    baseline = evidence.baseline
    if baseline is None or is_known(baseline.features) or not {"signal", "process"} & {*scenarios}:
        return ""
    return "unknown signal: less than 1.2 periods were recorded; judge it with a higher frequency"


def _cause_of_broken(broken: FailedTrial) -> Cause:
    words = f": {broken.words}" if broken.words else ""
    if broken.flaw == "flood":
        return Cause("flood", f"{broken.node} computes without a pause: a loop without rospy.Rate")
    if broken.flaw == "writes without end":
        return Cause("endless output", f"{broken.node} writes to its log without end")
    if broken.flaw == "not connected":
        return Cause("not connected", f"neither node receives the other's topic{words}")
    return Cause("crash", f"{broken.node} ended by itself{words}")


def _baseline(evidence: CourseworkEvidence) -> BaselineTrial:
    assert evidence.baseline is not None
    return evidence.baseline


def _launch(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    return Cause("launch", f"no launch file starts both nodes: {evidence.missing}")


def _rate(node: str, channel_of: Callable[[BaselineTrial], Channel]) -> "_Explain":
    def explain(evidence: CourseworkEvidence, figures: Figures) -> Cause:
        channel = channel_of(_baseline(evidence))
        if not channel.rate():
            return Cause("silent", f"the {node} sends nothing")
        if not channel.is_regular():
            return Cause(
                "too seldom",
                f"the {node} sends too seldom, at irregular times: one of: only if a value has"
                " changed, or an iteration of its loop sometimes takes long",
            )
        return Cause("too seldom", f"the {node} sends too seldom: its loop is slower than 10 Hz")

    return explain


def _distorted_signal(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    baseline = _baseline(evidence)
    if len(baseline.signal.values) < 3:
        return Cause("silent", "the signal generator sends nothing")
    if baseline.features.signal.sine is None or not oscillates(baseline.signal):
        return Cause(
            "constant",
            f"{baseline.signal.name} does not oscillate: one of: its amplitude or frequency is"
            " 0, or its time does not advance",
        )
    return Cause("distorted", f"{baseline.signal.name} is not a sine")


def _nan(node: str) -> "_Explain":
    return lambda evidence, figures: Cause(
        "nan",
        f"the {node} sends NaN: one of: the root of a number below 0 (sine / amplitude, as float32,"
        " may exceed 1), 0 / 0, or the arc sine of more than 1",
    )


def _amplitude(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    named = evidence.parameters.value_of(GENERATOR, "amplitude")
    assert named is not None
    measured = number(figures["signal", "amplitude"])
    return Cause("amplitude", f"the amplitude is {measured}, where {named[0]} is {named[1]:g}")


def _frequency(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    named = evidence.parameters.value_of(GENERATOR, "frequency")
    assert named is not None
    signal, measured = _baseline(evidence).features.signal, figures["signal", "frequency"]
    assert measured is not None
    if signal.rate and _is_alias(measured, frequencies_of(*named), signal.rate):
        return Cause(
            "undersampled",
            f"{signal.rate:.3g} messages per second are too few for {named[0]}: {named[1]:g}: they"
            f" show a sine of {measured:.3g} rad/s",
        )
    unit = ", in rad/s or Hz" if len(frequencies_of(*named)) > 1 else ""
    return Cause(
        "frequency",
        f"the frequency is {measured:.3g} rad/s, where {named[0]} is {named[1]:g}{unit}",
    )


def _is_alias(measured: float, frequencies: Sequence[float], rate: float) -> bool:
    """Return True if a faster sine of a frequency looks like the measured one when sampled."""
    turn = 2.0 * math.pi * rate
    for wanted in frequencies:
        if wanted > 0.5 * turn:
            folded = abs(wanted - turn * round(wanted / turn))
            if abs(folded - measured) < 0.05 * max(folded, measured):
                return True
    return False


def _fields(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    baseline = _baseline(evidence)
    sine = baseline.features.signal.sine
    assert sine is not None
    stated = ", ".join(
        f"{name} {value:g}"
        for name, value in baseline.constants.items()
        if role_of(name, GENERATOR_ROLES) in ("amplitude", "frequency")
    )
    return Cause(
        "fields",
        f"the messages have {stated}, but the signal's amplitude is {sine.amplitude:.3g} and its"
        f" frequency {sine.frequency:.3g} rad/s",
    )


def _distorted_output(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    baseline = _baseline(evidence)
    if len(baseline.output.values) < 3:
        return Cause("silent", "the process node sends nothing")
    if baseline.features.process is None:
        return Cause("constant", f"{baseline.output.name} is constant, whatever the signal")
    return Cause(
        "distorted",
        f"{baseline.output.name} is neither a sine of the signal's frequency, nor a rectified one:"
        " one of: the phase is shifted by a formula that is not always valid (the sign of the"
        " cosine), by an amplitude or frequency that the signal does not have, or values are lost",
    )


def _unchanged_gain(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    return Cause("unchanged", "the process node does not change the amplitude")


def _unchanged_phase(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    return Cause("unchanged", "the process node does not shift the phase")


def _negative(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    features = _baseline(evidence).features
    process, sine = features.process, features.signal.sine
    assert process is not None and sine is not None
    # A record of a few periods seldom has a sample at the lowest point.
    needed = max(process.gain * sine.amplitude, process.offset - process.lowest)
    return Cause(
        "negative",
        f"the output goes down to {process.lowest:.3g}: its offset is {process.offset:.3g}, where"
        f" at least {needed:.3g} is needed, or a rectifier",
    )


def _gain(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    named = evidence.parameters.value_of(PROCESS, "gain")
    assert named is not None
    measured = number(figures["process", "gain"])
    return Cause(
        "amplitude", f"the output has {measured} of the amplitude, where {named[0]} is {named[1]:g}"
    )


def _phase(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    named = evidence.parameters.value_of(PROCESS, "phase_shift")
    assert named is not None
    measured = number(figures["process", "phase_shift"], "rad")
    return Cause("phase", f"the phase shift is {measured}, where {named[0]} is {named[1]:g}")


def _free_running(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    return Cause(
        "free-running",
        "the output keeps oscillating without a signal: it is computed from a clock, not from"
        " the messages",
    )


def _restart(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    if evidence.restart is not None and evidence.restart.after is None:
        return Cause("restart", "after a restart of the generator, no output follows the signal")
    return Cause(
        "restart",
        "after a restart of the generator the output differs: one of: state of the first run is"
        " kept, such as its time, or the output depends on when the generator starts",
    )


def _hard_coded(node: str) -> "_Explain":
    return lambda evidence, figures: Cause(
        "hard-coded", f"no parameter affects the {node}: its values are in the code"
    )


def _unread(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    parts = []
    for one in evidence.parameters.unread():
        if one.other_names:
            parts.append(f"{one.name} has no effect, but {' or '.join(one.other_names)} has")
        elif not one.is_mentioned:
            parts.append(f"{one.name} has no effect: no source mentions it")
        else:
            parts.append(f"{one.name} has no effect: one of: it is not read, or read and not used")
    return Cause("unread", "; ".join(parts))


def _yaml(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    assert evidence.parameters is not None
    files: Mapping[str, str] = evidence.parameters.unused_files
    return Cause("yaml", "; ".join(f"{name}: {why}" for name, why in files.items()))


def _namespace(evidence: CourseworkEvidence, figures: Figures) -> Cause:
    names = ", ".join(evidence.outside or ())
    stays = "stays" if len(evidence.outside or ()) == 1 else "stay"
    return Cause(
        "namespace",
        f"{names} {stays} outside the namespace of the nodes: remove the / at the start of the"
        " name",
    )


_Explain = Callable[[CourseworkEvidence, Figures], Cause]
_CAUSES: Dict[Tuple[str, str], _Explain] = {
    ("launch", "missing_nodes"): _launch,
    ("signal", "rate"): _rate(GENERATOR, lambda baseline: baseline.signal),
    ("signal", "distortion"): _distorted_signal,
    ("signal", "not_finite"): _nan(GENERATOR),
    ("signal", "amplitude_error"): _amplitude,
    ("signal", "frequency_error"): _frequency,
    ("signal", "field_error"): _fields,
    ("process", "rate"): _rate(PROCESS, lambda baseline: baseline.output),
    ("process", "distortion"): _distorted_output,
    ("process", "not_finite"): _nan(PROCESS),
    ("process", "gain_change"): _unchanged_gain,
    ("process", "shift"): _unchanged_phase,
    ("process", "below_zero"): _negative,
    ("process", "gain_error"): _gain,
    ("process", "shift_error"): _phase,
    ("restart", "free_running"): _free_running,
    ("restart", "change"): _restart,
    ("parameters", "of_generator"): _hard_coded(GENERATOR),
    ("parameters", "of_process"): _hard_coded(PROCESS),
    ("parameters", "unread"): _unread,
    ("yaml", "unused"): _yaml,
    ("namespace", "outside"): _namespace,
}
