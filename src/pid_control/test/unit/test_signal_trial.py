"""Tests of the runs of a coursework: a trial's nodes, and a session's records and clock."""

import contextlib
import itertools
import math
import pathlib
from typing import Any, Dict, Iterator, List, Optional, Tuple, Type
from unittest import mock

import pytest

from pid_control.judging.record import Pause
from pid_control.programs.node_queries import NodeTopics
from pid_control.programs.package_messages import MessageTypeError
from pid_control.runner.clock import SimulatedClock, WallClock
from pid_control.runner.judging_errors import BusyMachineError, JudgingError, TimeLimitExceeded
from pid_control.signal_runner import signal_session
from pid_control.signal_runner import trial as trial_module
from pid_control.signal_judging.evidence import FailedTrial
from pid_control.signal_runner.coursework import Coursework, find_coursework
from pid_control.signal_runner.node_pair import NodePair
from pid_control.signal_runner.signal_session import SignalSession
from pid_control.signal_runner.trial import NotConnectedError, Trial, TrialError
from pid_control.verdicts.judgement import NOT_JUDGED, PASSED
from played_coursework import Loop, Played, PlayedNode, generator, process

COURSEWORKS = pathlib.Path(__file__).resolve().parents[1] / "courseworks"


def good(name: str) -> Coursework:
    return find_coursework(str(COURSEWORKS / name), [], {"PATH": "/usr/bin:/bin"})


def session_of(*scenarios: str) -> SignalSession:
    return SignalSession(mock.Mock(), scenarios, False, 60.0, {}, mock.Mock(), mock.Mock())


@pytest.mark.parametrize(
    ("group", "names"), [("", ["/a/gain"]), ("/group", ["/a/gain", "/group/a/gain"])]
)
def test_trial_in_a_namespace_keeps_global_names_of_parameters(
    group: str, names: List[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A source that reads a global name is not at fault: only topics are compared."""
    kept = {"/rosdistro": "one", "/rosversion": "1", "/run_id": "a", "/use_sim_time": False}
    server: Dict[str, Any] = {"/stale": 1.0, **kept}
    monkeypatch.setattr("rospy.get_param_names", lambda: list(server))
    monkeypatch.setattr("rospy.delete_param", server.pop)
    monkeypatch.setattr("rospy.set_param", server.__setitem__)
    for is_simulated in (True, False):
        bench = mock.Mock()
        with Trial(bench, mock.Mock(), [], {"/a/gain": 2.0}, 0.0, is_simulated, group):
            wanted = {**kept, **dict.fromkeys(names, 2.0), "/use_sim_time": is_simulated}
            assert server == wanted
        assert bench.mock_calls == [mock.call.use_clock(is_simulated), mock.call.listen({})]


def test_trial_knows_the_parameters_that_its_nodes_have_set(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    server = {"/a/gain": 2.0, "/a/set": 1.0, "/ab/set": 3.0, "/set": 4.0}
    monkeypatch.setattr("rospy.get_param_names", lambda: list(server))
    monkeypatch.setattr("rospy.get_param", server.__getitem__)
    node = mock.Mock(global_name="/a")
    trial = Trial(mock.Mock(), mock.Mock(), [node], {"/a/gain": 2.0}, 0.0)
    assert trial.own_parameters() == {"/a/set": 1.0}


@pytest.mark.parametrize(("is_simulated", "passed"), [(True, 0.0), (False, 0.5)])
def test_trial_by_the_machine_clock_is_not_late_after_a_node_has_ended(
    is_simulated: bool, passed: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0, is_simulated)
    trial._running["/a"] = mock.Mock()
    begin = trial.now
    monkeypatch.setattr("time.monotonic", iter([7.0, 7.5]).__next__)
    process = trial._running["/a"]
    trial.stop_node(mock.Mock(global_name="/a"))
    assert trial.now - begin == pytest.approx(passed)
    assert process.mock_calls == [mock.call.interrupt(), mock.call.end()]
    assert trial._running == {}


def test_trial_names_its_busiest_node_and_ends_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("time.sleep", mock.Mock())
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0)
    for name, times in (("/a", [0.5, 0.6]), ("/b", [0.0, 0.3]), ("/c", [0.9, 0.9])):
        process = mock.Mock(status=None, writes_without_end=False)
        process.processor_time.side_effect = times
        trial._running[name] = process
    with pytest.raises(TrialError) as error:
        trial._check(True)
    found = error.value
    assert (found.flaw, found.node, found.words, str(found)) == ("flood", "/b", "", "/b: flood")
    trial.__exit__(None, None, None)
    for process in trial._running.values():
        process.end.assert_called_once_with()


def test_trial_starts_its_nodes_in_the_group_and_lists_all_their_topics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start = mock.Mock()
    monkeypatch.setattr(trial_module, "ProgramProcess", start)
    bench, master = mock.Mock(), mock.Mock(environment={"ROS_MASTER_URI": "x"}, pid=7)
    one = good("sine_classes").nodes[0]
    trial = Trial(bench, master, [one], {}, 0.0, group="/group")
    trial.start_node(one)
    names = ["__name:=processor", "__ns:=/group/lab"]
    command = one.command._replace(argv=[*one.command.argv, *names])
    start.assert_called_once_with(command, {"ROS_MASTER_URI": "x"}, [7])
    Trial(bench, master, [one], {}, 0.0).start_node(one._replace(namespace="/"))
    assert start.call_args[0][0].argv[-1] == "__ns:=/"
    # Both answer, but the second node publishes late, and then one more topic.
    late = [
        NodeTopics({}, {"/t": "F"}),
        NodeTopics({"/y": "F"}, {"/t": "F"}),
        NodeTopics({"/y": "F", "/a": "F"}, {"/t": "F"}),
    ]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda seconds: now.append(now.pop() + seconds))
    now = [0.0]
    topics = {"/group/b": NodeTopics({"/group/s": "F"}, {"/t": "F"})}
    bench.topics_of.side_effect = lambda name: topics.get(name, late[0])
    bench.pop_count.return_value = 0
    trial = Trial(bench, master, [one], {}, 1e9, group="/group")
    trial._restless = mock.Mock(is_its_own=lambda: False)
    trial._running["/a"] = mock.Mock(status=None, writes_without_end=False)
    step, steps = trial.step, [0]

    def run_step() -> None:
        steps[0] += 1
        if steps[0] in (100, 110):  # the latter one is in the time for further topics
            late.pop(0)
        step()

    monkeypatch.setattr(trial, "step", run_step)
    trial._clock = mock.Mock()
    nodes = [one, one._replace(namespace="/", name="b")]
    assert trial.topics(nodes) == ["/a", "/group/s", "/t", "/y"]
    assert 0.9 < trial.now < 1.7
    bench.topics_of.assert_any_call("/group/lab/processor")


@pytest.mark.parametrize(
    ("answers", "publishes"),
    [([0], False), ([9, 0], False), ([9, 9, 5, 1], False), ([2, 4, 8, 16], True)],
)
def test_late_messages_are_no_evidence_of_the_machine_clock(
    answers: List[int], publishes: bool
) -> None:
    bench = mock.Mock()
    trial = Trial(bench, mock.Mock(), [], {}, 0.0)
    pause = mock.Mock(side_effect=[Pause(1.0, 1.0, 1.0, n) for n in answers])
    trial._clock = mock.Mock(pause=pause)
    assert trial.publishes_while_paused() is publishes
    assert pause.call_args_list == [mock.call(trial.now, bench.pop_count)] * len(answers)
    trial._clock.pause = mock.Mock(return_value=None)  # by the machine's clock
    assert not trial.publishes_while_paused()


@pytest.mark.parametrize(
    ("distortions", "is_noted"),
    [([0.01], False), ([0.5, 0.01], True), ([0.5, 0.5, 0.02], True), ([0.5, 0.5, 0.5], False)],
)
def test_distorted_record_is_repeated_twice_at_most(
    distortions: List[float], is_noted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of("signal")
    records = iter(mock.Mock(features=mock.Mock(distortion=one)) for one in distortions)
    monkeypatch.setattr(session, "_repeat_baseline", lambda _: next(records))
    session._repeat_if_distorted(next(records), mock.Mock())
    assert next(records, None) is None
    assert bool(session.notes) is is_noted
    assert not is_noted or session.notes == [
        "a record was repeated, because its distortion was 0.50: the machine was busy, or the nodes"
        " do not always behave the same"
    ]


@pytest.mark.parametrize("publishes", [(True, False), (False, True)])
def test_node_that_publishes_in_either_pause_of_the_clock_uses_the_machines(
    publishes: Tuple[bool, bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    session, trial = session_of("signal"), mock.Mock()
    trial.publishes_while_paused.side_effect = publishes
    monkeypatch.setattr(session, "_run_periods", mock.Mock())
    monkeypatch.setattr(session, "_check_heard", mock.Mock(side_effect=AssertionError))
    with pytest.raises(JudgingError) as error:
        session._record_baseline(trial, mock.Mock())
    assert str(error.value) == (
        "it uses the machine's clock (time.time(), time.sleep()), not ROS's (rospy.get_time(),"
        " rospy.Rate): judge it with --real-time"
    )


@pytest.mark.parametrize(
    ("answers", "error"),
    [
        ([False, False], None),
        ([None, False, False, False], None),
        ([None, False, True, False], JudgingError),
        ([None, False] * 3, BusyMachineError),
    ],
)
def test_clock_of_values_is_looked_at_until_it_is_certain(
    answers: List[Optional[bool]],
    error: Optional[Type[Exception]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, left = session_of("signal"), iter(answers)
    channels, trial, pair = [mock.Mock(), mock.Mock()], mock.Mock(now=7.0), mock.Mock()
    monkeypatch.setattr(session, "_channels", mock.Mock(return_value=channels))
    moved = mock.Mock(side_effect=lambda *_: next(left))
    monkeypatch.setattr(signal_session, "moved_in_pauses", moved)
    says = "uses the machine's clock|^this machine is too busy to see which clock the nodes use$"
    expected = pytest.raises(error, match=says) if error else contextlib.nullcontext()
    with expected:
        session._check_clock(trial, pair, 10.0)
    assert next(left, "none") == "none"
    lengths = [0.2, 0.3, 0.2, 0.4, 0.3, 0.2, 0.4, 0.3]
    assert trial.run_with_pauses.call_args == mock.call(pytest.approx(lengths))
    session._channels.assert_called_with(pair, 7.0)  # type: ignore[attr-defined]
    pauses = trial.run_with_pauses.return_value
    assert moved.call_args_list[:2] == [mock.call(one, pauses) for one in channels]
    with contextlib.suppress(StopIteration):
        session._check_clock(trial, pair, 0.5)  # of a slow loop, not for long
    assert trial.run_with_pauses.call_args[0][0] == [2.0, 3.0, 2.0, 4.0, 3.0, 2.0, 4.0, 3.0]


def test_notes_of_the_parameters_are_those_of_the_judgement(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for scenario in ("parameters", "yaml", "namespace"):
        session, trials = session_of("signal", scenario), mock.Mock(notes=["not tried: /a"])
        session.evidence.baseline, session._pair = mock.Mock(), mock.Mock()
        monkeypatch.setattr(session, "_run_baseline", mock.Mock())
        monkeypatch.setattr(session, "_run_in_group", mock.Mock())
        make = mock.Mock(return_value=trials)
        monkeypatch.setattr(signal_session, "ParameterTrials", make)
        assert session.run() == ""
        in_group = scenario == "namespace"
        assert session._run_in_group.called is in_group  # type: ignore[attr-defined]
        assert session.notes == ([] if in_group else ["not tried: /a"])
        given = session._coursework, session._pair, session.evidence.baseline, session._features
        assert make.call_args_list == ([] if in_group else [mock.call(*given)])
        assert session.evidence.parameters is (None if in_group else trials.run.return_value)
    # A signal that is not a sine has no features to compare.
    session.evidence.baseline.features.signal.sine = None
    session._scenarios = ["parameters"]
    assert session.run() == "" and not make.called


def test_failures_of_each_scenario_are_kept_with_their_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = session_of("signal", "parameters", "namespace")
    session.evidence.baseline, session._pair = mock.Mock(), mock.Mock()
    monkeypatch.setattr(session, "_run_baseline", mock.Mock())
    group = mock.Mock(side_effect=NotConnectedError("a publishes nothing"))
    monkeypatch.setattr(session, "_run_in_group", group)
    trials = mock.Mock(notes=["a note"])
    trials.run.side_effect = TrialError("crash", "/a", "NameError: x")
    monkeypatch.setattr(signal_session, "ParameterTrials", mock.Mock(return_value=trials))
    assert session.run() == "" and session.notes == ["a note"]
    failures = {
        "parameters": FailedTrial("crash", "/a", "NameError: x"),
        "namespace": FailedTrial("not connected", "", "a publishes nothing"),
    }
    assert session.evidence.broken == failures
    session._run_baseline.side_effect = TrialError("flood", "/b")  # type: ignore[attr-defined]
    group.reset_mock()
    assert session.run() == "" and not group.called
    assert session.evidence.broken["signal"] == FailedTrial("flood", "/b", "")


def test_record_of_a_baseline_is_settled_paused_checked_and_restarted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The whole order, of which each step needs the one before."""
    for real_time, scenarios, is_sine in (
        (False, ["signal", "restart"], True),
        (False, ["signal", "restart"], False),
        (True, ["signal"], True),
    ):
        session = session_of(*scenarios)
        session._real_time = real_time
        calls = mock.Mock()
        trial, pair = calls.trial, mock.Mock()
        trial.now = 3.0
        trial.publishes_while_paused.return_value = False
        trial.run.side_effect = lambda duration: setattr(trial, "now", trial.now + duration)
        signal, output = mock.Mock(), mock.Mock()
        signal.rate.return_value = 25.0 if is_sine else None
        calls.features_of.return_value.signal.sine = 1.0 if is_sine else None
        calls.channels.return_value = signal, output
        for name in (
            "run_periods",
            "check_heard",
            "channels",
            "features_of",
            "constants",
            "check_clock",
            "run_restart",
            "check_lateness",
        ):
            monkeypatch.setattr(session, f"_{name}", getattr(calls, name))
        baseline = session._record_baseline(trial, pair)
        assert baseline is session.evidence.baseline
        assert baseline == (
            calls.features_of.return_value,
            signal,
            output,
            calls.constants.return_value,
            trial.own_parameters.return_value,
        )
        of_clock = [] if real_time or not is_sine else [mock.call.check_clock(trial, pair, 25.0)]
        of_restart = (
            [] if real_time or not is_sine else [mock.call.run_restart(trial, pair, 4.0, 5.0)]
        )
        assert calls.mock_calls == [
            mock.call.trial.connect(pair),
            mock.call.trial.run(1.0),
            mock.call.trial.run(1.0),
            mock.call.trial.publishes_while_paused(),
            mock.call.run_periods(trial, pair, 4.0),
            mock.call.trial.publishes_while_paused(),
            mock.call.check_heard(),
            mock.call.channels(pair, 4.0),
            mock.call.features_of(signal, output),
            mock.call.constants(signal, 4.0),
            mock.call.trial.own_parameters(),
            *of_clock,
            *of_restart,
            mock.call.check_lateness(trial),
        ]


@pytest.mark.parametrize(
    ("real_time", "is_as_started", "fast", "oscillates"),
    [
        (False, True, [False], True),
        (False, True, [False], False),
        (False, False, [False], True),
        (False, True, [True, True, False], True),
        (True, True, [True], True),
        (True, False, [True], True),
    ],
)
def test_baseline_is_repeated_in_the_order_of_the_nodes_and_with_finer_steps(
    real_time: bool,
    is_as_started: bool,
    fast: List[bool],
    oscillates: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, calls, make = session_of("signal"), mock.Mock(), mock.MagicMock()
    process, generator = nodes = good("wave_loops").nodes
    session._coursework.nodes = nodes if is_as_started else nodes[::-1]  # type: ignore[misc]
    session._real_time = real_time
    session.evidence.baseline = baseline = mock.Mock()
    baseline.signal.name, baseline.output.name = "/s/data", "/p/data"
    trial, pair = make.return_value.__enter__.return_value, NodePair(generator, process, {}, {}, {})
    trial.find_pair.return_value = pair
    calls.is_too_fast.side_effect = fast
    for name in ("record_baseline", "repeat_baseline", "is_too_fast", "repeat_if_distorted"):
        monkeypatch.setattr(session, f"_{name}", getattr(calls, name))
    monkeypatch.setattr(session, "_trial", make)
    monkeypatch.setattr(signal_session, "oscillates", lambda one: oscillates)
    session._run_baseline()
    assert trial.mock_calls == [mock.call.start(), mock.call.find_pair()]
    finer = [] if real_time else [mock.call.repeat_baseline(pair), mock.call.is_too_fast()]
    assert calls.mock_calls == [
        mock.call.record_baseline(trial, pair)
        if is_as_started
        else mock.call.repeat_baseline(pair),
        *([] if real_time else [mock.call.is_too_fast()]),
        *finer * (len(fast) - 1),
        *([mock.call.repeat_if_distorted(baseline, pair)] if oscillates and not real_time else []),
    ]
    assert session._step == pytest.approx(0.01 if real_time else 0.01 * 0.2 ** (len(fast) - 1))
    assert session._pair is pair and session.notes == [
        "signal_generator.py is the signal generator, process.py the process node",
        "signal: /s/data; output: /p/data",
    ]


@pytest.mark.parametrize(("frequency", "silence"), [(9.0, 2.0), (1.0, 2.0 * math.pi), (0.1, 30.0)])
def test_restart_of_the_generator_is_recorded_like_the_baseline(
    frequency: float, silence: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, calls, pair = session_of("restart"), mock.Mock(), mock.Mock()
    session.evidence.baseline = mock.Mock()
    session.evidence.baseline.features.signal.sine.frequency = frequency
    trial = calls.trial
    trial.now = 10.0
    trial.run.side_effect = lambda duration: setattr(trial, "now", trial.now + duration)
    calls.channels.side_effect = lambda _, begin: (f"signal {begin:.2f}", f"output {begin:.2f}")
    for name in ("channels", "features_of"):
        monkeypatch.setattr(session, f"_{name}", getattr(calls, name))
    monkeypatch.setattr(signal_session, "is_sine_like", calls.is_sine_like)
    session._run_restart(trial, pair, 4.0, 9.5)
    stopped = 10.5 + silence
    calls.is_sine_like.assert_called_once_with("output 10.50", frequency, 10.5, stopped)
    again = f"{stopped + 1.0:.2f}"
    calls.features_of.assert_called_once_with(f"signal {again}", f"output {again}")
    assert trial.mock_calls == [
        mock.call.stop_node(pair.generator),
        mock.call.run(0.5 + silence),
        mock.call.run_past(session.evidence.baseline.output.topic),
        mock.call.start_node(pair.generator),
        mock.call.connect_again(pair),
        mock.call.run(1.0),
        mock.call.run(5.5),
    ]
    assert session.evidence.restart == (
        calls.is_sine_like.return_value,
        calls.features_of.return_value.process,
        "signal 4.00",
        "output 4.00",
    )


@pytest.mark.parametrize(
    ("periods_per_s", "runs"),
    [
        (1.0, [5.0]),
        (0.44, [5.0]),
        (0.4, [5.0, 0.7]),
        (0.43, [5.0, 0.5]),  # at least half a second
        (0.1, [5.0, 17.2]),
        (0.05, [5.0, 25.0]),  # until 30 s
        (0.0, [5.0] * 6),
        (None, [5.0] * 6),
    ],
)
def test_record_is_as_long_as_its_periods_need(
    periods_per_s: Optional[float], runs: List[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    session, trial = session_of("signal"), mock.Mock(now=12.0)
    trial.run.side_effect = lambda duration: setattr(trial, "now", trial.now + duration)
    channels = mock.Mock(return_value=("signal", "output"))
    monkeypatch.setattr(session, "_channels", channels)

    def features_of(signal: str) -> Any:
        assert signal == "signal"
        length = trial.now - 11.0
        is_sine = periods_per_s is not None
        return mock.Mock(sine=mock.Mock(periods=periods_per_s * length) if is_sine else None)

    monkeypatch.setattr(signal_session, "signal_features", features_of)
    pair = mock.Mock()
    session._run_periods(trial, pair, 11.0)
    assert [call[0][0] for call in trial.run.call_args_list] == pytest.approx([4.0, *runs[1:]])
    channels.assert_called_with(pair, 11.0)


def test_other_parameters_are_tried_with_the_nodes_of_their_coursework(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    coursework = good("wave_loops")
    process, generator = coursework.nodes
    session, calls = session_of("parameters"), mock.Mock()
    pair = NodePair(generator, process, {}, {}, {})
    session._pair = pair
    changed = [one._replace(program=f"other_{one.program}") for one in coursework.nodes]
    for nodes in (changed, changed[:1], []):
        calls.reset_mock()
        trial = calls.trial
        trial.now = 2.0
        trial.run.side_effect = lambda duration: setattr(trial, "now", trial.now + duration)
        make = mock.MagicMock()
        make.return_value.__enter__.return_value = trial
        calls.channels.return_value = "signal", "output"
        monkeypatch.setattr(session, "_trial", make)
        for name in ("run_periods", "channels", "features_of", "check_lateness"):
            monkeypatch.setattr(session, f"_{name}", getattr(calls, name))
        found = session._features(coursework._replace(nodes=nodes, parameters={"/a": 1}))
        used = NodePair(
            changed[1] if len(nodes) > 1 else generator,
            changed[0] if nodes else process,
            {},
            {},
            {},
        )
        assert found is calls.features_of.return_value and session._pair is pair
        make.assert_called_once_with({"/a": 1})
        assert calls.mock_calls == [
            mock.call.trial.start(),
            mock.call.trial.connect(used),
            mock.call.trial.run(1.0),
            mock.call.run_periods(trial, used, 3.0),
            mock.call.channels(used, 3.0),
            mock.call.check_lateness(trial),
            mock.call.features_of("signal", "output"),
        ]
    trial.start.side_effect = TrialError("crash", "/a")
    with pytest.raises(TrialError):
        session._features(coursework)
    assert session._pair is pair


def test_topics_outside_the_namespace_are_all_that_do_not_begin_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, trial = session_of("namespace"), mock.Mock()
    session._pair = pair = mock.Mock()
    make = mock.MagicMock()
    make.return_value.__enter__.return_value = trial
    monkeypatch.setattr(session, "_trial", make)
    trial.topics.return_value = ["/judged_group/a", "/judged_group2/b", "/judged_group", "/a"]
    session._run_in_group()
    make.assert_called_once_with(group="/judged_group")
    assert trial.mock_calls == [
        mock.call.start(),
        mock.call.topics([pair.process, pair.generator]),
    ]
    assert session.evidence.outside == ["/a", "/judged_group", "/judged_group2/b"]


@pytest.mark.parametrize("real_time", [False, True])
def test_good_coursework_passes_by_either_clock(
    real_time: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    played = Played(monkeypatch, real_time=real_time)
    judgement = played.judge()
    assert judgement.verdict == PASSED, judgement.failures
    figures = {(one.scenario, one.metric): one.value for one in judgement.findings}
    assert figures["signal", "rate"] == pytest.approx(10.0, abs=0.1)
    assert figures["signal", "amplitude"] == pytest.approx(2.0, abs=0.01)
    assert figures["signal", "frequency"] == pytest.approx(3.0, abs=0.01)
    assert figures["process", "phase_shift"] == pytest.approx(1.2, abs=0.01)
    assert figures["parameters", "of_generator"] == 2.0 and figures["parameters", "of_process"] == 3
    assert played.session.notes[-2:] == [
        "signal_generator.py is the signal generator, process.py the process node",
        "signal: /signal/data; output: /proc_signal/data",
    ]
    # The whole record, of a baseline and a restart, is for the picture.
    restart = played.session.evidence.restart
    assert restart is not None and played.session.evidence.baseline is not None
    assert restart.signal.times[0] == played.session.evidence.baseline.signal.times[0]
    if not real_time:  # it starts again between two outputs: no order of both loops is random
        again = played.machine.started_at[2]
        latest = max(time for time in restart.output.times if time <= again)
        assert 0.029 < again - latest < 0.061
    assert played.machine.nodes == {} and sorted(set(played.machine.ended)) == [
        "/judged_group/process",
        "/judged_group/signal_generator",
        "/process",
        "/signal_generator",
    ]


def slow_sine(node: PlayedNode) -> Iterator[None]:
    """Publish a sine of so many seconds that it is known late."""
    begin = node.time()
    while True:
        node.publish("signal", math.sin(0.5 * (node.time() - begin)))
        yield


def echo(node: PlayedNode) -> Iterator[None]:
    """Answer with the signal of 0.4 s ago, and with half of its amplitude, above 0."""
    node.subscribe("signal")
    kept = [0.0] * 4
    while True:
        kept.append(node.latest("signal"))
        node.publish("proc_signal", 1.0 + 0.5 * kept.pop(0))
        yield


def disturbed(node: PlayedNode) -> Iterator[None]:
    """Publish a sine, but every third value is missing in the first run of both nodes."""
    begin, is_first = node.time(), len(node.machine.commands) <= 2
    for number in itertools.count():
        is_lost = is_first and number % 3 == 0
        node.publish("time", node.time() - begin)
        node.publish("signal", 0.0 if is_lost else math.sin(3.0 * (node.time() - begin)))
        yield


def test_record_that_a_busy_machine_distorted_is_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    played = Played(monkeypatch, "signal", signal_generator=disturbed, process=echo)
    judgement = played.judge()
    assert judgement.verdict == PASSED, judgement.failures
    assert "a record was repeated, because its distortion was" in played.session.notes[-1]


def buffered(node: PlayedNode) -> Iterator[None]:
    """Answer with the message of a second ago, and with what it had stored after a restart."""
    node.subscribe("signal")
    kept = [0.0] * 9
    while True:
        kept.append(node.latest("signal"))
        node.publish("proc_signal", 2.0 + 0.5 * kept.pop(0))
        yield


def test_rest_of_a_buffer_after_a_restart_is_no_change(monkeypatch: pytest.MonkeyPatch) -> None:
    judgement = Played(monkeypatch, "restart", process=buffered).judge()
    assert judgement.verdict == PASSED, judgement.failures
    [change] = [one.value for one in judgement.findings if one.metric == "change"]
    assert change == pytest.approx(0.0, abs=0.01)


def test_slow_signal_is_recorded_for_more_than_two_periods(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    played = Played(monkeypatch, "signal", "restart", signal_generator=slow_sine, process=echo)
    judgement = played.judge()
    assert judgement.verdict == PASSED, judgement.failures
    baseline = played.session.evidence.baseline
    assert baseline is not None
    period = 4.0 * math.pi
    assert 2.2 * period <= baseline.signal.times[-1] - baseline.signal.times[0] < 30.5


def late_topics(node: PlayedNode) -> Iterator[None]:
    """Publish a further topic every 2 s, and subscribe only then."""
    for number in range(60):
        node.publish(f"topic_{number // 20}", 0.0)
        yield
    yield from process(node)


def late_start(node: PlayedNode) -> Iterator[None]:
    """Have no topics for 8 s, as a node that loads a large library."""
    for _ in range(80):
        yield
    yield from process(node)


def by_time(node: PlayedNode) -> Iterator[None]:
    """Compute the output from the generator's time; the signal is not received."""
    node.subscribe("time")
    while True:
        node.publish("proc_signal", 1.5 + math.sin(3.0 * node.latest("time") + 1.2))
        yield


@pytest.mark.parametrize("loop", [late_topics, late_start, by_time])
def test_process_node_with_other_topics_passes(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    judgement = Played(monkeypatch, "signal", "process", process=loop).judge()
    assert judgement.verdict == PASSED, judgement.failures


def free_running(node: PlayedNode, omega: float = 3.0) -> Iterator[None]:
    node.subscribe("signal")
    while True:
        node.publish("proc_signal", 1.5 + math.sin(omega * node.time() + 1.2))
        yield


def slowly_free_running(node: PlayedNode) -> Iterator[None]:
    """Publish a sine that only rises, or only falls, for six seconds."""
    return free_running(node, 0.5)


def counting(node: PlayedNode) -> Iterator[None]:
    """Shift the phase by a time that is counted, and so goes on at a restart."""
    node.subscribe("signal", "time")
    count, before = 0, 0.0
    while True:
        count += node.latest("time") != before
        before = node.latest("time")
        node.publish("proc_signal", 1.5 + math.sin(0.3 * count + 1.2))
        yield


def flood(node: PlayedNode) -> Iterator[None]:
    """Publish without a pause, but seem idle while the messages are taken."""
    node.load, node.period = 1.0, 0.01
    for _ in generator(node):
        node.spent += 0.5
        for _ in range(300):
            node.publish("time", 0.0)
        yield


def restless(node: PlayedNode) -> Iterator[None]:
    node.load, node.is_restless = 1.0, True
    yield from process(node)


def endless(node: PlayedNode) -> Iterator[None]:
    for _ in generator(node):
        node.writes_without_end = True
        yield


def crash(node: PlayedNode) -> Iterator[None]:
    for _ in process(node):
        if node.latest("time") > 0.5:
            node.status, node.words = 1, "NameError: x"
        yield


def crash_at_once(node: PlayedNode) -> Iterator[None]:
    node.status, node.words = 1, "SyntaxError: x"
    yield from process(node)


def deaf(node: PlayedNode) -> Iterator[None]:
    node.subscribe("Signal")
    while True:
        node.publish("proc_signal", 0.0)
        yield


def silent(node: PlayedNode) -> Iterator[None]:
    node.subscribe("signal")
    node.publish("proc_signal", 0.0)
    while True:
        yield


def absolute(node: PlayedNode) -> Iterator[None]:
    node.space = ""
    yield from generator(node)


@pytest.mark.parametrize(
    ("scenarios", "programs", "flaws", "says"),
    [
        (["restart"], {"process": free_running}, ["free-running"], "keeps oscillating"),
        (
            ["restart"],
            {"signal_generator": slow_sine, "process": slowly_free_running},
            ["free-running"],
            "keeps oscillating",
        ),
        (["restart"], {"process": counting}, ["restart"], "the output differs"),
        (["signal"], {"signal_generator": flood}, ["flood"], "/signal_generator computes"),
        (["signal"], {"process": restless}, ["flood"], "/process computes without a pause"),
        (["signal"], {"signal_generator": endless}, ["endless output"], "/signal_generator writes"),
        (["signal"], {"process": crash}, ["crash"], "/process ended by itself: NameError: x"),
        (["signal"], {"process": crash_at_once}, ["crash"], "/process ended by itself: Syntax"),
        (
            ["signal"],
            {"process": deaf},
            ["not connected"],
            "process.py publishes /proc_signal (std_msgs/Float32) and subscribes to /Signal",
        ),
        (["process"], {"process": silent}, ["silent"], "the process node sends nothing"),
        (
            ["namespace"],
            {"signal_generator": absolute},
            ["namespace"],
            "/signal, /time stay outside the namespace",
        ),
    ],
)
def test_flaw_of_a_played_coursework_is_named(
    scenarios: List[str],
    programs: Dict[str, Loop],
    flaws: List[str],
    says: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judgement = Played(monkeypatch, *scenarios, **programs).judge()
    assert judgement.flaws() == flaws, judgement.failures
    assert says in judgement.failures[0].cause.sentence


def by_machine(node: PlayedNode) -> Iterator[None]:
    node.is_by_machine = True
    return generator(node)


def with_time_of_machine(node: PlayedNode) -> Iterator[None]:
    begin = node.machine.time
    while True:
        node.publish("signal", math.sin(3.0 * (node.machine.time - begin)))
        yield


@pytest.mark.parametrize("loop", [by_machine, with_time_of_machine])
def test_machine_clock_of_a_node_is_not_judged(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(JudgingError, match="it uses the machine's clock"):
        Played(monkeypatch, "signal", signal_generator=loop).judge()


def test_fast_coursework_is_run_again_with_finer_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fast(loop: Loop) -> Loop:
        def make(node: PlayedNode) -> Iterator[None]:
            node.period = 0.008
            return loop(node)

        return make

    loops = {"signal_generator": fast(generator), "process": fast(process)}
    played = Played(monkeypatch, "signal", **loops)
    judgement = played.judge()
    assert judgement.verdict == PASSED, judgement.failures
    figures = {one.metric: one.value for one in judgement.findings if one.scenario == "signal"}
    assert figures["rate"] == pytest.approx(125.0, abs=2.0)
    assert len(played.machine.commands) == 2 * 2


def test_judgement_ends_at_its_time_limit_and_on_a_late_machine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    played = Played(monkeypatch, "signal", time_limit=1.0)
    judgement = played.judge()
    assert (judgement.verdict, judgement.reason) == (NOT_JUDGED, "1 s are over")
    assert played.machine.nodes == {}
    for scenario in ("signal", "parameters"):
        late = Played(monkeypatch, scenario, real_time=True)
        late.machine.late_from = 0 if scenario == "signal" else 2
        with pytest.raises(BusyMachineError, match=r"the judge itself was 0\.[1-9]\d\d s late"):
            late.judge()


def test_node_that_cannot_be_started_or_is_not_connected_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start = mock.Mock(side_effect=OSError(8, "Exec format error"))
    monkeypatch.setattr(trial_module, "ProgramProcess", start)
    bench = mock.Mock()
    node = good("sine_classes").nodes[0]
    trial = Trial(bench, mock.Mock(), [node], {}, 0.0, group="/group")
    with pytest.raises(TrialError) as error:
        trial.start_node(node)
    found = error.value
    assert (found.flaw, found.node, found.words) == ("crash", "/lab/processor", "Exec format error")
    inputs = dict.fromkeys(["/a", "/f", "/e", "/d", "/c", "/b"], "F")
    pair = mock.Mock(inputs=inputs, outputs={"/y": "F"}, others={"/z": "F"})
    pair.process.global_name = "/lab/processor"
    bench.links_of.return_value = {"/a", "/clock"}
    monkeypatch.setattr(trial, "_wait", lambda is_done: is_done())
    says = "^/lab/processor does not receive /b, /c, /d, /e, /f$"
    with pytest.raises(NotConnectedError, match=says):
        trial.connect(pair)
    bench.listen.assert_called_once_with({**inputs, "/y": "F", "/z": "F"})
    bench.links_of.assert_called_with("/group/lab/processor")
    bench.links_of.return_value = {*inputs, "/clock"}
    trial.connect_again(pair)


def test_wait_of_a_trial_asks_now_and_then_and_ends_when_its_nodes_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda seconds: now.append(now.pop() + seconds))
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0)
    watch = mock.Mock()
    trial._running["/a"] = mock.Mock(watch=watch)
    step = mock.Mock(side_effect=lambda: setattr(trial, "now", trial.now + 0.01))
    monkeypatch.setattr(trial, "step", step)
    asked: List[float] = []

    def is_done(after: float) -> bool:
        asked.append(now[0])
        return now[0] >= after

    assert trial._wait(lambda: is_done(100.0)) and not step.called
    assert trial._wait(lambda: is_done(100.5))
    gaps = [after - before for before, after in zip(asked[1:], asked[2:])]
    assert len(gaps) == 10 and all(0.05 < gap < 0.061 for gap in gaps)
    # Only once the nodes rest, or have computed for long: they may start on a busy machine.
    for idle, busy in ((True, 0.0), (False, 20.1)):
        begin = now[0]
        watch.is_idle.side_effect = lambda: idle and now[0] > begin + 25.0
        watch.busy.side_effect = lambda: busy if now[0] > begin + 25.0 else 20.0
        assert not trial._wait(lambda: False)
        assert now[0] - begin == pytest.approx(25.0, abs=0.02)
    watch.is_idle.side_effect, begin = lambda: True, now[0]
    assert not trial._wait(lambda: False)
    assert now[0] - begin == pytest.approx(20.0, abs=0.02)
    # Nor before some time of the clock, however long a step takes.
    step.side_effect = lambda: (setattr(trial, "now", trial.now + 0.5), now.append(now.pop() + 9.0))
    start = trial.now
    assert not trial._wait(lambda: False) and trial.now - start == 3.5


def test_pauses_of_a_trial_are_longer_than_the_runs_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now, slept = [100.0], []
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", slept.append)
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0)
    ran: List[float] = []

    def run(duration: float) -> None:
        ran.append(duration)
        trial.now += duration
        now[0] += 0.5 * duration

    monkeypatch.setattr(trial, "run", run)
    begin = trial.now
    pauses = trial.run_with_pauses([0.5, 0.01, 4.0])
    assert ran == [0.5, 0.01, 4.0, 0.5]  # the last pause is between messages too
    assert slept == pytest.approx([0.75, 0.05, 3.0])
    assert [pause - begin for pause in pauses] == pytest.approx([0.5, 0.51, 4.51])


def test_trial_runs_past_the_latest_message_of_a_topic(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = mock.Mock()
    trial = Trial(bench, mock.Mock(), [], {}, 0.0)
    step = mock.Mock(side_effect=lambda: setattr(trial, "now", trial.now + 0.01))
    monkeypatch.setattr(trial, "step", step)
    begin = trial.now
    for late, steps in ((-0.001, 4), (0.015, 2), (0.031, 0), (0.059, 0)):
        trial.now, step.call_count = begin, 0
        times = [[begin - late - 9.0], [begin - late], []]
        bench.channels.return_value = [mock.Mock(times=one) for one in times]
        trial.run_past("/y")
        assert step.call_count == steps
    bench.channels.assert_called_with("/y")
    # Without a recent message, it ends after a second.
    step.call_count = 0
    bench.channels.return_value = [mock.Mock(times=[begin - 5.0])]
    trial.run_past("/y")
    assert step.call_count == pytest.approx(100, abs=1)


def test_step_of_a_trial_sets_the_clock_and_sees_a_flood_and_the_deadline(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = mock.Mock()
    trial = Trial(bench, mock.Mock(), [], {}, 50.0, step=0.002)
    trial._clock, trial._restless = mock.Mock(), mock.Mock(is_its_own=lambda: False)
    monkeypatch.setattr("time.monotonic", lambda: 50.0)
    for count, is_flood in ((200, False), (201, True)):
        bench.pop_count.return_value = count
        trial.step()
        trial._restless.update.assert_called_with(trial._clock.wait.return_value, is_flood)
    assert trial.now == pytest.approx(0.014)
    bench.set_clock.assert_called_with(trial.now)
    assert trial._clock.wait.call_args[0][0] == pytest.approx(0.004)
    monkeypatch.setattr("time.monotonic", lambda: 50.1)
    with pytest.raises(TimeLimitExceeded):
        trial.step()


def test_nodes_of_a_trial_start_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a simulated clock, it jumps after the first: its loop begins again then."""
    for is_simulated, jump in ((True, 1.0), (False, 0.0)):
        bench, processes = mock.Mock(), [mock.Mock(), mock.Mock()]
        monkeypatch.setattr(trial_module, "ProgramProcess", mock.Mock(side_effect=processes))
        nodes = good("wave_loops").nodes
        trial = Trial(bench, mock.Mock(), nodes, {}, 1e12, is_simulated)
        calls: List[Any] = []
        monkeypatch.setattr(trial, "run", lambda duration: calls.append(duration))
        monkeypatch.setattr(trial, "_wait_for_clock", lambda: calls.append(trial.now - begin))
        begin = trial.now
        trial.start()
        assert calls == pytest.approx([0.0, 0.03, jump, 0.03])
        assert list(trial._running) == ["/process", "/signal_generator"]
        assert isinstance(trial._clock, SimulatedClock if is_simulated else WallClock)
        assert trial._restless is not None
        for is_idle in (True, False):  # computing time of the first, and of the younger ones
            trial._restless.update(is_idle)
        processes[0].watch.busy.assert_called_once_with()
        assert trial.latest == 0.0
        trial._clock.latest = 0.7  # type: ignore[union-attr]
        assert trial.latest == (0.0 if is_simulated else 0.7)


def test_pair_of_a_trial_has_the_topics_that_appear_late(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = mock.Mock()
    process, generator = nodes = good("wave_loops").nodes
    topics: Dict[str, Any] = {
        "/group/process": NodeTopics({"/p": "F"}, {"/s": "F"}),
        "/group/signal_generator": NodeTopics({"/s": "F"}, {}),
    }
    bench.topics_of.side_effect = topics.get
    bench.listen.side_effect = MessageTypeError
    trial = Trial(bench, mock.Mock(), nodes, {}, 0.0, group="/group")
    monkeypatch.setattr(trial, "_wait", lambda is_done: is_done())
    late = NodeTopics({"/s": "F", "/time": "F"}, {})
    run = mock.Mock(side_effect=lambda _: topics.update({"/group/signal_generator": late}))
    monkeypatch.setattr(trial, "run", run)
    assert trial.find_pair() == (generator, process, {"/s": "F"}, {"/p": "F"}, {"/time": "F"})
    run.assert_called_once_with(0.5)
    bench.listen.assert_called_once_with({"/p": "F", "/s": "F"})
    del topics["/group/process"]
    trial._running["/a"] = mock.Mock()
    with pytest.raises(NotConnectedError) as error:
        trial.find_pair()
    assert str(error.value) == (
        "process.py does not answer; signal_generator.py publishes /s (F), /time (F) and subscribes"
        " to nothing"
    )


def test_search_for_a_pair_is_over_once_all_nodes_rest_with_their_topics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    trial = Trial(mock.Mock(), mock.Mock(), [mock.Mock(), mock.Mock()], {}, 0.0)
    watch = mock.Mock()
    trial._running["/a"] = mock.Mock(watch=watch)
    trial.now = 50.0
    monkeypatch.setattr("time.monotonic", lambda: 80.0)
    nothing, sends, hears = (
        NodeTopics({}, {}),
        NodeTopics({"/x": "F"}, {}),
        NodeTopics({}, {"/y": "F"}),
    )
    for found, since, since_by_machine, is_idle, is_over in (
        ([sends, hears], 46.9, 76.9, True, True),
        ([sends, hears], 46.9, 76.9, False, False),
        ([sends, hears], 47.1, 76.9, True, False),
        ([sends, hears], 46.9, 77.1, True, False),
        ([sends, nothing], 46.9, 76.9, True, False),
        ([sends], 46.9, 76.9, True, False),
    ):
        watch.is_idle.return_value = is_idle
        topics = dict(zip("ab", found))
        assert trial._is_over(topics, since, since_by_machine) is is_over


def test_clock_of_the_nodes_is_waited_for_until_they_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [50.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda seconds: now.append(now.pop() + seconds))
    for is_simulated, listeners, seconds in ((True, 0, 1.0), (True, 1, 0.0), (False, 0, 0.0)):
        bench, begin = mock.Mock(), now[0]
        trial = Trial(bench, mock.Mock(), [], {}, 0.0, is_simulated)
        process = mock.Mock(status=None, writes_without_end=False)
        process.watch.is_idle.return_value = True
        trial._running["/a"] = process
        bench.clock_listeners.return_value = listeners
        trial._wait_for_clock()
        assert now[0] - begin == pytest.approx(seconds, abs=0.02)
        waits = [mock.call(1.0)] if is_simulated and listeners else []
        assert process.watch.wait_idle.call_args_list == waits


def test_program_without_the_clock_is_started_after_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As one without ROS; with its process the trial ends at once."""
    now = [50.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda seconds: now.append(now.pop() + seconds))
    bench = mock.Mock()
    bench.clock_listeners.return_value = 0
    trial = Trial(bench, mock.Mock(), [], {}, 0.0)
    process = mock.Mock(status=None, writes_without_end=False)
    process.watch.is_idle.side_effect = [False] * 150 + [True] * 9
    trial._running["/a"] = process
    trial._wait_for_clock()
    assert 1.4 < now[0] - 50.0 < 1.7 and bench.set_clock.called
    process.status = 1
    process.watch.is_idle.side_effect = None
    process.watch.is_idle.return_value = False
    process.last_words.return_value = "SyntaxError: x"
    with pytest.raises(TrialError) as error:
        trial._wait_for_clock()
    assert (error.value.node, error.value.words) == ("/a", "SyntaxError: x")


def test_loop_faster_than_the_finest_step_is_not_judged() -> None:
    session = session_of("signal")
    session.evidence.baseline = mock.Mock()
    session.evidence.baseline.signal.rate.return_value = 4000.0
    session.evidence.baseline.output.rate.return_value = None
    for step, is_finest in ((0.01, False), (0.002, False), (0.0019, True), (0.0004, True)):
        session._step = step
        expected = contextlib.nullcontext() if not is_finest else pytest.raises(JudgingError)
        with expected as error:
            assert session._is_too_fast()
    assert str(error.value) == (
        "unknown signal: more than 4000 messages per second; lower the rate, or judge it with"
        " --real-time"
    )
