"""Tests of the judgement of a coursework: figures, causes, unknown values."""

import math
import pathlib
from typing import Any, Dict, List, Optional
from xml.etree import ElementTree

import pytest

from pid_control.charts.chart import Panel
from pid_control.signal_judging import coursework_picture
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
from pid_control.verdicts.reports import as_sentences, as_table

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


#: Report of a coursework with as many flaws as one can have at once.
TABLE = """
scenario    what                                          figure     limit
launch      nodes that no launch file starts              2          <= 0     FAILED
signal      messages per second                           10 Hz      >= 9.5
            difference from a sine, RMS per amplitude     0.04       <= 0.05
            NaN or infinite values                        1          <= 0     FAILED
            amplitude                                     2
            angular frequency                             2 rad/s
            difference from the amplitude's parameter     0.333      <= 0.05  FAILED
            difference from the frequency's parameter     0.2        <= 0.02  FAILED
            difference from the message's own fields      0.25       <= 0.05  FAILED
process     messages per second                           8 Hz       >= 4.5
            difference from the shape, RMS per amplitude  0.08       <= 0.1
            NaN or infinite values                        2          <= 0     FAILED
            amplitude, per that of the signal             0.5
            change of the amplitude                       0.5        >= 0.05
            phase shift                                   1 rad
            magnitude of the phase shift                  0.9 rad    >= 0.1
            offset                                        0.75
            depth below zero, per amplitude               0.25       <= 0.02  FAILED
            difference from the amplitude's parameter     0.1        <= 0.05  FAILED
            difference from the phase's parameter         0.665 rad  <= 0.1   FAILED
restart     output without a signal                       0          <= 0
            change of the output after the restart        0.2        <= 0.1   FAILED
parameters  parameters that change the signal             2          >= 1
            parameters that change the output             3          >= 1
            parameters without effect                     2          <= 0     FAILED
yaml        YAML files without effect                     2          <= 0     FAILED
namespace   topics outside the namespace                  3          <= 0     FAILED
"""
NAN = (
    "sends NaN: one of: the root of a number below 0 (sine / amplitude, as float32, may exceed 1),"
    " 0 / 0, or the arc sine of more than 1"
)
SENTENCES = f"""
launch: nodes that no launch file starts 2, at most 0
  likely cause (launch): no launch file starts both nodes: it has none

signal: NaN or infinite values 1, at most 0
  likely cause (nan): the signal generator {NAN}

process: NaN or infinite values 2, at most 0
  likely cause (nan): the process node {NAN}

signal: difference from the amplitude's parameter 0.333, at most 0.05
  likely cause (amplitude): the amplitude is 2, where /amplitude is 3

process: difference from the amplitude's parameter 0.1, at most 0.05
  likely cause (amplitude): the output has 0.5 of the amplitude, where /gain is 0.9

signal: difference from the frequency's parameter 0.2, at most 0.02
  likely cause (frequency): the frequency is 2 rad/s, where /omega is 2.5, in rad/s or Hz

signal: difference from the message's own fields 0.25, at most 0.05
  likely cause (fields): the messages have amplitude 1.5, frequency 2.2, but the signal's amplitude
    is 2 and its frequency 2 rad/s

process: difference from the phase's parameter 0.665 rad, at most 0.1 rad
  likely cause (phase): the phase shift is 1 rad, where /angle is 2

process: depth below zero, per amplitude 0.25, at most 0.02
  likely cause (negative): the output goes down to -0.25: its offset is 0.75, where at least 1 is
    needed, or a rectifier

restart: change of the output after the restart 0.2, at most 0.1
  likely cause (restart): after a restart of the generator the output differs: one of: state of the
    first run is kept, such as its time, or the output depends on when the generator starts

parameters: parameters without effect 2, at most 0
  likely cause (unread): /a/b has no effect: no source mentions it; /c has no effect, but /d or /e
    has

yaml: YAML files without effect 2, at most 0
  likely cause (yaml): a.yaml: no launch file loads it; b.yaml: x.launch loads it, but sets other
    values

namespace: topics outside the namespace 3, at most 0
  likely cause (namespace): /signal, /time, /x stay outside the namespace of the nodes: remove the
    / at the start of the name

failed: launch, nan, amplitude, frequency, fields, phase, negative, restart, unread, yaml,
  namespace
"""


def test_report_of_many_flaws_has_each_figure_and_cause() -> None:
    tried = [
        ParameterEffect("/amplitude", 3.0, "amplitude", {GENERATOR}, is_predicted=True),
        ParameterEffect("/omega", 2.5, "frequency", {GENERATOR}, is_predicted=True),
        ParameterEffect("/gain", 0.9, "gain", {PROCESS}, is_predicted=True),
        ParameterEffect("/angle", 2.0, "phase_shift", {PROCESS}, is_predicted=True),
        ParameterEffect("/rate", 2.0, "rate", {PROCESS}, is_predicted=True),
        ParameterEffect("/a/b", 2.0, "", set(), is_mentioned=False),
        ParameterEffect("/c", 2.0, "", set(), ["/d", "/e"]),
    ]
    found = evidence(
        output=lambda time: 0.75 + math.sin(2.0 * time + 1.0),
        constants={"amplitude": 1.5, "frequency": 2.2},
        tried=tried,
    )
    found.missing, found.outside = "it has none", ["/signal", "/time", "/x"]
    one, other = found.baseline, found.restart
    assert one is not None and one.features.signal.sine is not None
    assert one.features.process is not None and other is not None and found.parameters is not None
    sine, process = one.features.signal.sine, one.features.process
    features_ = TrialFeatures(
        one.features.signal._replace(sine=sine._replace(distortion=0.04)),
        process._replace(distortion=0.08, shifts=(1.0, 0.9)),
    )
    signal = one.signal._replace(values=[math.nan, *one.signal.values[1:]])
    times = [1.25 * time for time in one.output.times]
    output = Channel("/y", "", times, [math.nan, math.inf, *one.output.values[2:]])
    found.baseline = one._replace(features=features_, signal=signal, output=output)
    found.restart = other._replace(after=process._replace(gain=0.6, offset=0.9))
    files = {
        "a.yaml": "no launch file loads it",
        "b.yaml": "x.launch loads it, but sets other values",
    }
    found.parameters = found.parameters._replace(unused_files=files)
    judgement = judged(found)
    assert as_table(judgement) == TABLE.strip("\n")
    assert as_sentences(judgement).split() == SENTENCES.split()


@pytest.mark.parametrize(
    ("constants", "error"),
    [
        ({"amplitude": 2.0, "frequency": 2.0}, 0.0),
        ({"amplitude": 2.0, "frequency": 1.0 / math.pi}, 0.0),
        ({"amplitude": 2.0, "frequency_hz": 2.0}, 1.0 - 1.0 / (2.0 * math.pi)),
        ({"amplitude": 2.5, "frequency": 2.0}, 0.2),
        ({"phase": 9.0, "data": 5.0}, None),
    ],
)
def test_fields_of_the_messages_are_compared_with_the_signal(
    constants: Dict[str, float], error: Optional[float]
) -> None:
    figures = {one.metric: one.value for one in judged(evidence(constants=constants)).findings}
    assert figures["field_error"] == pytest.approx(error, abs=1e-6)


def test_depth_below_zero_is_a_share_of_the_outputs_amplitude() -> None:
    judgement = judged(evidence(output=lambda time: 2.0 * math.sin(2.0 * time + 1.0) + 1.0))
    figures = {(one.scenario, one.metric): one.value for one in judgement.findings}
    assert figures["process", "below_zero"] == pytest.approx(0.5, abs=0.01)


def test_limits_name_only_metrics() -> None:
    assert list(LIMITS) == ALL


@pytest.mark.parametrize(
    ("interval", "says"),
    [
        (
            lambda index: 0.3 + 0.01 * (index % 2),
            "the process node sends too seldom: its loop is slower than 10 Hz",
        ),
        (
            lambda index: (0.05, 0.1, 0.9)[index % 3],
            "the process node sends too seldom, at irregular times: one of: only if a value has"
            " changed, or an iteration of its loop sometimes takes long",
        ),
    ],
)
def test_seldom_messages_are_a_slow_loop_only_at_regular_times(interval: Any, says: str) -> None:
    times = [sum(interval(index) for index in range(count)) for count in range(40)]
    output = Channel("/y", "data", times, [math.sin(2.0 * time + 1.0) + 1.0 for time in times])
    found = evidence()
    assert found.baseline is not None
    found.baseline = found.baseline._replace(output=output)
    [failure] = judged(found).failures
    assert failure.cause == ("too seldom", says)


@pytest.mark.parametrize(
    ("changes", "flaw", "says"),
    [
        (
            {"signal": lambda time: 1.0},
            "constant",
            "/signal/data does not oscillate: one of: its amplitude or frequency is 0, or its time"
            " does not advance",
        ),
        (
            {"signal": lambda time: math.copysign(1.0, math.sin(2.0 * time))},
            "distorted",
            "/signal/data is not a sine",
        ),
        (
            {"output": lambda time: 3.0},
            "constant",
            "/proc_signal/data is constant, whatever the signal",
        ),
        (
            {"output": lambda time: math.sin(3.1 * time) + 1.0},
            "distorted",
            "/proc_signal/data is neither a sine of the signal's frequency, nor a rectified one:"
            " one of: the phase is shifted by a formula that is not always valid (the sign of the"
            " cosine), by an amplitude or frequency that the signal does not have, or values are"
            " lost",
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
            "the output goes down to -0.5: its offset is 0.5, where at least 1 is needed, or a"
            " rectifier",
        ),
        (
            {"constants": {"amplitude": 1.0, "samples": 5.0, "omega": 2.0}},
            "fields",
            "the messages have amplitude 1, omega 2, but the signal's amplitude is 2 and its"
            " frequency 2 rad/s",
        ),
    ],
)
def test_flaw_of_the_messages_is_the_first_cause(
    changes: Dict[str, Any], flaw: str, says: str
) -> None:
    judgement = judged(evidence(**changes))
    assert (judgement.verdict, judgement.failures[0].cause) == (FAILED, (flaw, says))
    assert "restart" not in judgement.flaws()


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
            ParameterEffect("/omega", 2.06, "frequency", {GENERATOR}, is_predicted=True),
            "the frequency is 2 rad/s, where /omega is 2.06, in rad/s or Hz",
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
        *(
            (
                ParameterEffect(f"/a/{role}", 2.0, role, set()),
                f"/a/{role} has no effect: one of: it is not read, or read and not used",
            )
            for role in ("amplitude", "frequency", "gain", "phase_shift")
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


def test_negative_output_needs_an_offset_as_deep_as_it_goes() -> None:
    found = evidence()
    assert found.baseline is not None and found.baseline.features.process is not None
    process = found.baseline.features.process._replace(lowest=-0.7)
    features_ = found.baseline.features._replace(process=process)
    found.baseline = found.baseline._replace(features=features_)
    found.restart = None
    assert cause(found) == (
        "the output goes down to -0.7: its offset is 1, where at least 1.7 is needed, or a"
        " rectifier"
    )


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
    assert cause(found) == (
        "the output keeps oscillating without a signal: it is computed from a clock, not from the"
        " messages"
    )
    found.restart = found.restart._replace(oscillates=False, after=None)
    assert cause(found) == "after a restart of the generator, no output follows the signal"
    assert judged(found).failures[0].what == "change of the output after the restart 1, at most 0.1"
    assert found.baseline is not None and found.baseline.features.process is not None
    before = found.baseline.features.process
    for start, changes, change in (
        ({}, {"offset": 1.5}, 0.5),
        ({}, {"offset": 0.5}, 0.5),
        ({"offset": -1.0}, {"offset": -1.5}, 0.5),
        ({"offset": 0.0}, {"offset": 0.2}, 0.4),  # as a share of the amplitude
        ({}, {"gain": 0.7}, 2.0 / 7.0),
        ({}, {"shifts": (1.4, 1.4)}, 0.4),
    ):
        features_ = found.baseline.features._replace(process=before._replace(**start))
        found.baseline = found.baseline._replace(features=features_)
        found.restart = found.restart._replace(after=before._replace(**{**start, **changes}))
        figures = {one.metric: one.value for one in judged(found).findings}
        assert figures["change"] == pytest.approx(change, abs=1e-6)
        assert "restart" in judged(found).flaws()


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
    worse = good._replace(process=good.process._replace(distortion=0.3))
    assert worse.distortion == 0.3
    assert good._replace(process=good.process._replace(distortion=3.0)).distortion == 1.0
    sine = good.signal.sine
    assert sine is not None
    for distortion, most in ((0.04, 0.3), (0.06, 0.06), (3.0, 1.0)):
        signal = good.signal._replace(sine=sine._replace(distortion=distortion))
        assert worse._replace(signal=signal).distortion == most
    assert good._replace(signal=good.signal._replace(sine=None)).distortion == 1.0
    square = evidence(signal=lambda time: math.copysign(1.0, math.sin(2.0 * time))).baseline
    assert square is not None and 0.1 < square.features.distortion < 1.0


def test_yaml_namespace_and_launch_name_the_source() -> None:
    found = evidence()
    assert found.parameters is not None
    found.parameters = found.parameters._replace(unused_files={"p.yaml": "no launch file loads it"})
    assert cause(found) == "p.yaml: no launch file loads it"
    found = evidence()
    found.outside = ["/signal"]
    assert cause(found) == (
        "/signal stays outside the namespace of the nodes: remove the / at the start of the name"
    )
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
        (FailedTrial("ended", "/process"), "crash", "/process ended by itself"),
        (
            FailedTrial("flood", "/process"),
            "flood",
            "/process computes without a pause: a loop without rospy.Rate",
        ),
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
    assert judgement == (FAILED, [], [("signal", broken.flaw, (flaw, says))], "", ())


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
    slightly = evidence()
    assert slightly.baseline is not None and slightly.baseline.features.process is not None
    process = slightly.baseline.features.process._replace(distortion=0.11)
    features_ = slightly.baseline.features._replace(process=process)
    slightly.baseline = slightly.baseline._replace(features=features_)
    for found, scenario in ((square, "signal"), (other, "process"), (slightly, "process")):
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
    flat = judge(evidence(signal=lambda time: 1.0), {}, ["signal", "process"])
    assert flat.reason == judgement.reason  # without limits, nothing fails
    # Nor can a ramp, which may be a slow sine.
    ramp = judge(evidence(signal=lambda time: time), LIMITS, ["signal", "process"])
    assert ramp.reason == judgement.reason
    assert judgement.reason == (
        "unknown signal: less than 1.2 periods were recorded; judge it with a higher frequency"
    )
    for scenario in ("signal", "process"):
        assert judge(found, LIMITS, [scenario]).reason == judgement.reason
    figures = {one.metric: one.value for one in judge(found, LIMITS, ["signal"]).findings}
    assert figures == {"rate": pytest.approx(10.0), "not_finite": 0.0, "distortion": None}


def test_reason_without_a_failure_is_not_judged() -> None:
    judgement = judge(evidence(), LIMITS, ALL, "3 s are over")
    assert (judgement.verdict, judgement.reason) == (NOT_JUDGED, "3 s are over")
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
    # Three are, and an output of three values is constant.
    three = Channel("/x", "data", [0.0, 0.1, 0.2], [0.0, 0.1, 0.2])
    found.baseline = found.baseline._replace(signal=three)
    assert judge(found, LIMITS, ["signal"]).flaws() == ["constant", "too seldom"]
    good = evidence().baseline
    assert good is not None
    features_ = good.features._replace(process=None)
    found.baseline = good._replace(output=three, features=features_)
    assert judge(found, LIMITS, ["process"]).flaws()[0] == "constant"


def test_flaws_are_sorted_and_each_cause_has_its_place() -> None:
    found = evidence(output=lambda time: 2.0 * math.sin(2.0 * time))
    found.outside = ["/signal"]
    flaws = judged(found).flaws()
    assert flaws == sorted(flaws, key=FLAWS.index) and flaws[-1] == "namespace"


def test_frequency_error_takes_rad_per_s_or_hz() -> None:
    assert frequency_error(2.0, 2.0) == frequency_error(2.0, -2.0) == 0.0
    assert frequency_error(4.0 * math.pi, 2.0) == pytest.approx(0.0)
    assert frequency_error(3.0, 2.0) == pytest.approx(1.0 / 3.0)


def test_picture_shows_both_channels_or_a_note(monkeypatch: "pytest.MonkeyPatch") -> None:
    nothing = as_picture(CourseworkEvidence(), "x")
    assert "anna &amp; ben" in as_picture(evidence(), "anna & ben: passed")
    for text in (as_picture(evidence(), "anna & ben: passed"), nothing):
        ElementTree.fromstring(text)
    assert "nothing was received" in nothing
    monkeypatch.setattr(coursework_picture, "as_svg", lambda panels: panels)
    found = evidence()
    one = found.baseline
    assert one is not None and found.restart is not None and one.features.signal.sine is not None
    # Of a restart, the whole record is shown; its time counts from the signal's first message.
    signal = channel("/signal", math.sin, 100.0, 20.0)
    output = channel("/y", math.cos, 100.04, 20.0)
    found.restart = found.restart._replace(signal=signal, output=output)
    panels: Any = as_picture(found, "anna")
    assert [(panel.title, len(panel.curves)) for panel in panels] == [("anna", 2), ("", 3)]
    sine, sent, shifted, zero, answered = [curve for panel in panels for curve in panel.curves]
    assert [(curve.name, curve.colour) for curve in (sine, sent, shifted, zero, answered)] == [
        ("sine", "#888888"),
        ("/signal/data", "#0072b2"),
        ("sine", "#888888"),
        ("0", "#bbbbbb"),
        ("/y/data", "#d55e00"),
    ]
    assert sent.times == [time - 100.0 for time in signal.times] and sent.values == signal.values
    assert sine.times == [time - 100.0 for time in one.signal.times]
    assert shifted.times == [time - 100.0 for time in one.output.times]
    later = [time - 100.0 for time in output.times]
    assert (answered.times, answered.values) == (later, output.values)
    assert (zero.times, zero.values) == ([later[0], later[-1]], [0.0, 0.0])
    assert [curve.is_held for curve in (sine, sent, shifted, zero, answered)] == [
        *[False] * 4,
        True,
    ]
    found.restart = None
    [[_, [sine, sent], *_], [_, [shifted, _, answered], *_]] = panels = as_picture(found, "anna")
    assert sine.times == sent.times == one.signal.times and shifted.times == one.output.times
    assert sine.values == pytest.approx(one.signal.values, abs=1e-6)
    assert shifted.values == pytest.approx(one.output.values, abs=1e-6)
    assert answered[2:4] == one.output[2:]
    # Neither a sine nor an output is needed.
    square = [math.copysign(1.0, one) for one in one.signal.values]
    features_ = TrialFeatures(one.features.signal._replace(sine=None), None)
    empty = Channel("/y", "", [], [])
    signal = one.signal._replace(values=square)
    found.baseline = one._replace(features=features_, signal=signal, output=empty)
    panels = as_picture(found, "anna")
    assert panels == [Panel("anna", [("/signal/data", "#0072b2", signal.times, square, False)])]
