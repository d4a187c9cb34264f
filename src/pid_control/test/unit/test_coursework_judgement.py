"""Tests of the judgement of a coursework: figures, causes, unknown values."""

import math
import pathlib
from typing import Any, Dict, List, Optional
from xml.etree import ElementTree

import pytest

from pid_control.signal_judging.channels import Channel
from pid_control.signal_judging.coursework_judgement import FLAWS, judge
from pid_control.signal_judging.coursework_picture import as_picture
from pid_control.signal_judging.evidence import (
    GENERATOR,
    PROCESS,
    BaselineTrial,
    CourseworkEvidence,
    FailedTrial,
    ParameterEffect,
    ParameterResults,
    RestartTrial,
    TrialFeatures,
)
from pid_control.signal_judging.features import process_features, signal_features
from pid_control.signal_judging.metric_values import frequency_error
from pid_control.signal_judging.scenarios import METRICS, SCENARIO_METRICS, SCENARIOS
from pid_control.verdicts.judgement import FAILED, NOT_JUDGED, PASSED, Judgement
from pid_control.verdicts.limits import read_limits

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config" / "judge_signals_limits.yaml"
LIMITS = read_limits(CONFIG.read_text("utf-8"), SCENARIO_METRICS)
ALL = list(SCENARIOS)


def channel(topic: str, of: Any, delay: float = 0.0, duration: float = 10.0) -> Channel:
    times = [0.1 * index for index in range(int(10.0 * duration))]
    return Channel(topic, "data", [time + delay for time in times], [of(time) for time in times])


def features(signal: Channel, output: Channel) -> TrialFeatures:
    found = signal_features(signal)
    if found.sine is None:
        return TrialFeatures(found, None)
    return TrialFeatures(found, process_features(output, signal.times, found.sine))


def evidence(
    signal: Any = lambda time: 2.0 * math.sin(2.0 * time),
    output: Any = lambda time: math.sin(2.0 * time + 1.0) + 1.0,
    constants: Optional[Dict[str, float]] = None,
    duration: float = 10.0,
    tried: Optional[List[ParameterEffect]] = None,
) -> CourseworkEvidence:
    """Return the evidence of a good coursework, with given changes."""
    found = CourseworkEvidence()
    one = channel("/signal", signal, 0.0, duration)
    other = channel("/proc_signal", output, 0.04, duration)
    found.baseline = BaselineTrial(features(one, other), one, other, constants or {})
    found.restart = RestartTrial(False, found.baseline.features.process, one, other)
    if tried is None:
        tried = [
            ParameterEffect("/amplitude", 2.0, "amplitude", {GENERATOR}, is_predicted=True),
            ParameterEffect("/omega", 2.0, "frequency", {GENERATOR}, is_predicted=True),
            ParameterEffect("/gain", 0.5, "gain", {PROCESS}, is_predicted=True),
            ParameterEffect("/angle", 1.0, "phase_shift", {PROCESS}, is_predicted=True),
        ]
    found.parameters = ParameterResults(tried, set(), {}, True)
    found.outside = []
    return found


def judged(found: CourseworkEvidence) -> Judgement:
    return judge(found, LIMITS, ALL)


def cause(found: CourseworkEvidence) -> str:
    """Return the sentence of the only cause."""
    judgement = judged(found)
    assert judgement.verdict == FAILED
    [sentence] = {failure.cause.sentence for failure in judgement.failures}
    return sentence


def test_good_coursework_passes_with_all_figures() -> None:
    constants = {"amplitude": 2.0, "frequency": 2.0, "sample_rate": 10.0, "samples": 5.0}
    judgement = judged(evidence(constants=constants))
    assert judgement.verdict == PASSED
    assert [finding.metric for finding in judgement.findings] == [
        metric for metrics in METRICS.values() for metric in metrics
    ]
    units = {one.metric: one.unit for one in judgement.findings if one.unit}
    radians = dict.fromkeys(("phase_shift", "shift", "shift_error"), "rad")
    assert units == {"rate": "Hz", "frequency": "rad/s", **radians}
    figures = {(one.scenario, one.metric): one.value for one in judgement.findings}
    assert figures["process", "gain"] == pytest.approx(0.5)
    assert figures["process", "phase_shift"] == pytest.approx(1.0)
    assert figures["process", "below_zero"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("frequency", [2.0, 1.0 / math.pi])
def test_frequency_of_the_messages_may_be_in_hz(frequency: float) -> None:
    constants = {"amplitude": 2.0, "frequency": frequency}
    assert judged(evidence(constants=constants)).verdict == PASSED


def test_depth_below_zero_is_a_share_of_the_outputs_amplitude() -> None:
    judgement = judged(evidence(output=lambda time: 2.0 * math.sin(2.0 * time + 1.0) + 1.0))
    figures = {(one.scenario, one.metric): one.value for one in judgement.findings}
    assert figures["process", "below_zero"] == pytest.approx(0.5, abs=0.01)


def test_limits_name_only_metrics() -> None:
    assert list(LIMITS) == ALL


@pytest.mark.parametrize(
    ("interval", "says"),
    [
        (lambda index: 0.3 + 0.01 * (index % 2), "too seldom: its loop is slower than 10 Hz"),
        (lambda index: (0.05, 0.1, 0.9)[index % 3], "one of: only if a value has changed"),
    ],
)
def test_seldom_messages_are_a_slow_loop_only_at_regular_times(interval: Any, says: str) -> None:
    times = [sum(interval(index) for index in range(count)) for count in range(40)]
    output = Channel("/y", "data", times, [math.sin(2.0 * time + 1.0) + 1.0 for time in times])
    found = evidence()
    assert found.baseline is not None
    found.baseline = found.baseline._replace(output=output)
    [failure] = judged(found).failures
    assert failure.cause.flaw == "too seldom" and says in failure.cause.sentence


@pytest.mark.parametrize(
    ("changes", "flaw", "says"),
    [
        ({"signal": lambda time: 1.0}, "constant", "/signal/data does not oscillate"),
        (
            {"signal": lambda time: math.copysign(1.0, math.sin(2.0 * time))},
            "distorted",
            "/signal/data is not a sine",
        ),
        ({"output": lambda time: 3.0}, "constant", "/proc_signal/data is constant"),
        (
            {"output": lambda time: math.sin(3.1 * time) + 1.0},
            "distorted",
            "/proc_signal/data is neither a sine of the signal's frequency, nor a rectified one",
        ),
        (
            {"output": lambda time: 1.0 + math.sin(2.0 * time), "tried": []},
            "unchanged",
            "the process node does not shift the phase",
        ),
        (
            {"output": lambda time: 2.0 + 2.0 * math.sin(2.0 * time + 1.0), "tried": []},
            "unchanged",
            "the process node does not change the amplitude",
        ),
        (
            {"output": lambda time: 0.5 + math.sin(2.0 * time + 1.0)},
            "negative",
            "the output goes down to -0.5: its offset is 0.5, where at least 1 is needed",
        ),
        (
            {"constants": {"amplitude": 1.0, "samples": 5.0, "omega": 2.0}},
            "fields",
            "the messages have amplitude 1, omega 2, but the signal's amplitude is 2",
        ),
    ],
)
def test_flaw_of_the_messages_is_the_first_cause(
    changes: Dict[str, Any], flaw: str, says: str
) -> None:
    judgement = judged(evidence(**changes))
    assert (judgement.verdict, judgement.flaws()[0]) == (FAILED, flaw)
    assert says in judgement.failures[0].cause.sentence


@pytest.mark.parametrize(
    ("tried", "says"),
    [
        (
            ParameterEffect("/amplitude", 3.0, "amplitude", {GENERATOR}, is_predicted=True),
            "the amplitude is 2, where /amplitude is 3",
        ),
        (
            ParameterEffect("/omega", 3.0, "frequency", {GENERATOR}, is_predicted=True),
            "the frequency is 2 rad/s, where /omega is 3, in rad/s or Hz",
        ),
        (
            ParameterEffect("/hz", 9.681690113816209, "frequency", {GENERATOR}, is_predicted=True),
            "10 messages per second are too few for /hz: 9.68169: they show a sine of 2 rad/s",
        ),
        (
            ParameterEffect("/f_hz", 2.0, "frequency", {GENERATOR}, is_predicted=True),
            "the frequency is 2 rad/s, where /f_hz is 2",
        ),
        (
            ParameterEffect(
                "/hz/rad_s", 1.0 / math.pi, "frequency", {GENERATOR}, is_predicted=True
            ),
            "the frequency is 2 rad/s, where /hz/rad_s is 0.31831",
        ),
        (
            ParameterEffect("/gain", 0.9, "gain", {PROCESS}, is_predicted=True),
            "the output has 0.5 of the amplitude, where /gain is 0.9",
        ),
        (
            ParameterEffect("/angle", 2.0, "phase_shift", {PROCESS}, is_predicted=True),
            "the phase shift is 1 rad, where /angle is 2",
        ),
        (
            ParameterEffect("/angle_deg", 1.0, "phase_shift", {PROCESS}, is_predicted=True),
            "the phase shift is 1 rad, where /angle_deg is 1",
        ),
        (
            ParameterEffect("/angle_rad", 417.2957795, "phase_shift", {PROCESS}, is_predicted=True),
            "the phase shift is 1 rad, where /angle_rad is 417.296",
        ),
        (
            ParameterEffect("/a/b", 2.0, "", set(), is_mentioned=False),
            "/a/b has no effect: no source mentions it",
        ),
        (ParameterEffect("/a/b", 2.0, "", set(), ["/b"]), "/a/b has no effect, but /b has"),
        (
            ParameterEffect("/a/frequency", 2.0, "frequency", set()),
            "/a/frequency has no effect: one of: it is not read, or read and not used",
        ),
    ],
)
def test_flaw_of_a_parameter_is_named(tried: ParameterEffect, says: str) -> None:
    others = [
        ParameterEffect("/x", 1.0, "", {GENERATOR, PROCESS}),
    ]
    assert cause(evidence(tried=[*others, tried])) == says


@pytest.mark.parametrize(
    "tried",
    [
        # In Hz, in degrees, a lag, of another unit, an amplitude, below 0, maybe used elsewhere.
        ParameterEffect("/hz", 2.0 / (2.0 * math.pi), "frequency", {GENERATOR}, is_predicted=True),
        ParameterEffect("/angle", math.degrees(1.0), "phase_shift", {PROCESS}, is_predicted=True),
        ParameterEffect("/f_hz", 1.0 / math.pi, "frequency", {GENERATOR}, is_predicted=True),
        ParameterEffect(
            "/angle_deg", math.degrees(1.0), "phase_shift", {PROCESS}, is_predicted=True
        ),
        ParameterEffect("/angle", -1.0, "phase_shift", {PROCESS}, is_predicted=True),
        ParameterEffect(
            "/angle_rad", 1.0 - 2.0 * math.pi, "phase_shift", {PROCESS}, is_predicted=True
        ),
        ParameterEffect("/angle", 1.19, "phase_shift", {PROCESS}, is_predicted=True),  # one sample
        ParameterEffect("/phase_samples", 10.0, "phase_shift", {PROCESS}),
        ParameterEffect("/gain", 1.0, "gain", {PROCESS}, is_predicted=True),
        ParameterEffect("/gain", -0.5, "gain", {PROCESS}, is_predicted=True),
        ParameterEffect("/offset", 1.0, "offset", set()),
        ParameterEffect("/chirp_duration", 1.0, "", set()),
    ],
)
def test_parameter_of_another_unit_or_case_is_not_blamed(tried: ParameterEffect) -> None:
    both = ParameterEffect("/x", 1.0, "", {GENERATOR, PROCESS})
    assert judged(evidence(tried=[both, tried])).verdict == PASSED


def test_flaws_of_parameters_state_what_was_measured() -> None:
    angle = ParameterEffect("/angle", 2.0, "phase_shift", {PROCESS}, is_predicted=True)
    size = ParameterEffect("/size", 4.0, "amplitude", {GENERATOR}, is_predicted=True)
    found = evidence(
        lambda time: 3.0 * math.sin(2.0 * time),
        lambda time: math.sin(2.0 * time - 1.0) + 1.0,
        tried=[angle, size],
    )
    sentences = {failure.cause.sentence for failure in judged(found).failures}
    assert "the phase shift is -1 rad, where /angle is 2" in sentences
    assert "the amplitude is 3, where /size is 4" in sentences


def test_unread_parameter_beside_one_of_its_role_is_not_blamed() -> None:
    unread = ParameterEffect("/prbs_amplitude", 1.0, "amplitude", set())
    read = ParameterEffect("/amplitude", 2.0, "amplitude", {GENERATOR, PROCESS})
    assert judged(evidence(tried=[unread, read])).verdict == PASSED


def test_no_parameter_is_hard_coded_unless_hidden_ones_are_read() -> None:
    found = evidence(tried=[])
    judgement = judged(found)
    assert judgement.flaws() == ["hard-coded"]
    assert [failure.cause.sentence for failure in judgement.failures] == [
        f"no parameter affects the {node}: its values are in the code"
        for node in (GENERATOR, PROCESS)
    ]
    found.parameters = ParameterResults([], {GENERATOR, PROCESS}, {}, False)
    judgement = judged(found)
    assert judgement.verdict == PASSED
    assert {one.metric: one.value for one in judgement.findings}["unused"] is None


def test_free_running_output_and_lost_restart_are_named() -> None:
    found = evidence()
    assert found.restart is not None
    found.restart = found.restart._replace(oscillates=True, after=None)
    assert "computed from a clock, not from the messages" in cause(found)
    found.restart = found.restart._replace(oscillates=False, after=None)
    assert "no output follows the signal" in cause(found)
    assert found.baseline is not None and found.baseline.features.process is not None
    for moved in ({"offset": 1.5}, {"offset": 0.5}, {"gain": 0.7}, {"shifts": (1.4, 1.4)}):
        after = found.baseline.features.process._replace(**moved)
        found.restart = found.restart._replace(after=after)
        assert "after a restart of the generator the output differs" in cause(found)


@pytest.mark.parametrize("node", [GENERATOR, PROCESS])
def test_nan_is_blamed_on_the_node_that_sends_it(node: str) -> None:
    found = evidence()
    assert found.baseline is not None
    name = "signal" if node == GENERATOR else "output"
    sent = getattr(found.baseline, name)
    wrong = sent._replace(values=[math.nan, *sent.values[1:]])
    found.baseline = found.baseline._replace(**{name: wrong})
    assert cause(found).startswith(f"the {node} sends NaN")


def test_distortion_is_that_of_the_signal_or_else_of_the_output() -> None:
    found = evidence().baseline
    assert found is not None and found.features.process is not None
    good = found.features
    assert good.distortion < 0.01
    assert good._replace(process=None).distortion == 1.0
    assert good._replace(process=good.process._replace(distortion=0.3)).distortion == 0.3
    square = evidence(signal=lambda time: math.copysign(1.0, math.sin(2.0 * time))).baseline
    assert square is not None and 0.1 < square.features.distortion < 1.0


def test_yaml_namespace_and_launch_name_the_source() -> None:
    found = evidence()
    assert found.parameters is not None
    found.parameters = found.parameters._replace(unused_files={"p.yaml": "no launch file loads it"})
    assert cause(found) == "p.yaml: no launch file loads it"
    found = evidence()
    found.outside = ["/signal", "/time"]
    assert cause(found).startswith("/signal, /time stay outside the namespace")
    assert judged(found).failures[0].what == "topics outside the namespace 2, at most 0"
    found.outside = ["/signal"]
    assert cause(found).startswith("/signal stays outside the namespace")
    found = evidence()
    found.missing = "it has none"
    assert cause(found) == "no launch file starts both nodes: it has none"


@pytest.mark.parametrize(
    ("broken", "flaw", "says"),
    [
        (
            FailedTrial("ended", "/process", "NameError: x"),
            "crash",
            "/process ended by itself: NameError: x",
        ),
        (FailedTrial("flood", "/process"), "flood", "/process computes without a pause"),
        (
            FailedTrial("writes without end", "/process"),
            "endless output",
            "/process writes to its log without end",
        ),
        (
            FailedTrial("not connected", "", "a; b"),
            "not connected",
            "neither node receives the other's topic: a; b",
        ),
    ],
)
def test_broken_trial_is_a_failure(broken: FailedTrial, flaw: str, says: str) -> None:
    found = CourseworkEvidence()
    found.broken["signal"] = broken
    judgement = judge(found, LIMITS, ["signal", "process"])
    assert (judgement.verdict, judgement.flaws()) == (FAILED, [flaw])
    assert says in judgement.failures[0].cause.sentence
    assert judgement.failures[0][:2] == ("signal", broken.flaw)


def test_nodes_that_are_not_connected_come_before_a_missing_launch_file() -> None:
    found = CourseworkEvidence()
    found.missing, found.broken["signal"] = "it has none", FailedTrial("not connected", "")
    assert judged(found).flaws() == ["not connected", "launch"]
    # A node that has ended, or sends without a pause, may be the reason that they are not.
    found.broken["namespace"], found.broken["process"] = (
        FailedTrial("flood", "/process"),
        FailedTrial("ended", "/process"),
    )
    assert judged(found).flaws() == ["crash", "flood", "not connected", "launch"]


def test_distorted_signal_or_output_has_no_further_figures() -> None:
    square = evidence(signal=lambda time: math.copysign(1.0, math.sin(2.0 * time)))
    other = evidence(output=lambda time: math.sin(3.1 * time) + 1.0)
    for found, scenario in ((square, "signal"), (other, "process")):
        judgement = judged(found)
        assert judgement.flaws() == ["distorted"]
        figures = [one.metric for one in judgement.findings if one.scenario == scenario]
        assert sorted(figures) == ["distortion", "not_finite", "rate"]


def test_too_short_record_cannot_be_judged() -> None:
    found = evidence(duration=3.3)  # 1.05 periods
    found.parameters = found.restart = None
    judgement = judge(found, LIMITS, ["signal", "process"])
    assert judgement.verdict == NOT_JUDGED
    measured = [one.metric for one in judgement.findings if one.scenario == "process"]
    assert measured == ["rate", "not_finite"]
    assert judge(found, LIMITS, ["launch"]).verdict == PASSED  # needs no signal
    # Nor can a ramp, which may be a slow sine.
    ramp = judge(evidence(signal=lambda time: time), LIMITS, ["signal", "process"])
    assert ramp.reason == judgement.reason
    assert judgement.reason.startswith("unknown signal: less than 1.2 periods")


def test_reason_without_a_failure_is_not_judged() -> None:
    assert judge(evidence(), LIMITS, ALL, "3 s are over").verdict == NOT_JUDGED
    assert judge(CourseworkEvidence(), {}, [], "").reason == "nothing was measured"


def test_silent_nodes_are_named() -> None:
    found = evidence()
    assert found.baseline is not None
    empty = Channel("/signal", "", [], [])
    nothing = TrialFeatures(signal_features(empty), None)
    found.baseline = BaselineTrial(nothing, empty, empty, {})
    found.restart = found.parameters = None
    judgement = judge(found, LIMITS, ["signal", "process"])
    assert judgement.flaws() == ["silent"]
    sentences = {failure.cause.sentence for failure in judgement.failures}
    assert sentences == {"the signal generator sends nothing", "the process node sends nothing"}
    # Two messages are no signal either.
    two = Channel("/signal", "data", [0.0, 0.1], [0.0, 0.1])
    found.baseline = found.baseline._replace(signal=two)
    failures = judge(found, LIMITS, ["signal"]).failures
    says = {failure.cause.sentence for failure in failures}
    assert len(failures) == 2 and says == {"the signal generator sends nothing"}


def test_flaws_are_sorted_and_each_cause_has_its_place() -> None:
    found = evidence(output=lambda time: 2.0 * math.sin(2.0 * time))
    found.outside = ["/signal"]
    flaws = judged(found).flaws()
    assert flaws == sorted(flaws, key=FLAWS.index) and flaws[-1] == "namespace"


def test_frequency_error_takes_rad_per_s_or_hz() -> None:
    assert frequency_error(2.0, 2.0) == frequency_error(2.0, -2.0) == 0.0
    assert frequency_error(4.0 * math.pi, 2.0) == pytest.approx(0.0)
    assert frequency_error(3.0, 2.0) == pytest.approx(1.0 / 3.0)


def test_picture_shows_both_channels_or_a_note() -> None:
    text = as_picture(evidence(), "anna & ben: passed")
    ElementTree.fromstring(text)
    assert "/signal/data" in text and "/proc_signal/data" in text and "anna &amp; ben" in text
    # The output is held; the time counts from the first message, to the end of the restart.
    curves = [part.split('"')[0].split() for part in text.split('points="')[1:]]
    assert len(curves[-1]) > 1.9 * len(curves[0]) and "15 s" not in text
    found = evidence()
    assert found.baseline is not None and found.restart is not None
    for name, duration in (("baseline", 10.0), ("restart", 20.0)):
        later = {one: channel(f"/{one}", math.sin, 100.0, duration) for one in ("signal", "output")}
        setattr(found, name, getattr(found, name)._replace(**later))
    text = as_picture(found, "x")
    assert ">15 s<" in text and "100 s" not in text
    nothing = as_picture(CourseworkEvidence(), "x")
    ElementTree.fromstring(nothing)
    assert "nothing was received" in nothing
