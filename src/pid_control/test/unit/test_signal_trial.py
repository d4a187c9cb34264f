"""Tests of the runs of a coursework: a trial's nodes, and a session's records and clock."""

import contextlib
import pathlib
from typing import Any, Dict, List, Optional, Tuple, Type
from unittest import mock

import pytest

from pid_control.judging.record import Pause
from pid_control.programs.node_queries import NodeTopics
from pid_control.runner.judging_errors import BusyMachineError, JudgingError
from pid_control.signal_runner import signal_session
from pid_control.signal_runner import trial as trial_module
from pid_control.signal_runner.coursework import Coursework, find_coursework
from pid_control.signal_runner.signal_session import SignalSession
from pid_control.signal_runner.trial import Trial, TrialError

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
    server: Dict[str, Any] = {"/stale": 1.0}
    monkeypatch.setattr("rospy.get_param_names", lambda: list(server))
    monkeypatch.setattr("rospy.delete_param", server.pop)
    monkeypatch.setattr("rospy.set_param", server.__setitem__)
    with Trial(mock.Mock(), mock.Mock(), [], {"/a/gain": 2.0}, 0.0, group=group):
        assert server == {**dict.fromkeys(names, 2.0), "/use_sim_time": True}


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
    process.end.assert_called_once_with()


def test_trial_names_its_busiest_node_and_ends_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("time.sleep", mock.Mock())
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0)
    for name, times in (("/a", [0.5, 0.6]), ("/b", [0.0, 0.3])):
        process = mock.Mock(status=None, writes_without_end=False)
        process.processor_time.side_effect = times
        trial._running[name] = process
    with pytest.raises(TrialError) as error:
        trial._check(True)
    assert (error.value.flaw, error.value.node) == ("flood", "/b")
    trial.__exit__(None, None, None)
    for process in trial._running.values():
        process.end.assert_called_once_with()


def test_trial_starts_its_nodes_in_the_group_and_lists_all_their_topics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start = mock.Mock()
    monkeypatch.setattr(trial_module, "ProgramProcess", start)
    bench = mock.Mock()
    bench.topics_of.return_value = NodeTopics({"/group/s": "F"}, {"/t": "F"})
    one = good("sine_classes").nodes[0]
    trial = Trial(bench, mock.Mock(), [one], {}, 0.0, group="/group")
    trial.start_node(one)
    assert start.call_args[0][0].argv[-2:] == ["__name:=processor", "__ns:=/group/lab"]
    monkeypatch.setattr(trial, "_wait", lambda is_done: is_done())
    monkeypatch.setattr(trial, "run", mock.Mock())
    assert trial.topics([one]) == ["/group/s", "/t"]
    bench.topics_of.assert_called_with("/group/lab/processor")


@pytest.mark.parametrize(
    ("answers", "publishes"),
    [([0], False), ([9, 0], False), ([9, 9, 5, 1], False), ([2, 4, 8, 16], True)],
)
def test_late_messages_are_no_evidence_of_the_machine_clock(
    answers: List[int], publishes: bool
) -> None:
    trial = Trial(mock.Mock(), mock.Mock(), [], {}, 0.0)
    trial._clock = mock.Mock(
        pause=mock.Mock(side_effect=[Pause(1.0, 1.0, 1.0, n) for n in answers])
    )
    assert trial.publishes_while_paused() is publishes


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
    assert not is_noted or "its distortion was 0.50" in session.notes[0]


@pytest.mark.parametrize("publishes", [(True, False), (False, True)])
def test_node_that_publishes_in_either_pause_of_the_clock_uses_the_machines(
    publishes: Tuple[bool, bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    session, trial = session_of("signal"), mock.Mock()
    trial.publishes_while_paused.side_effect = publishes
    monkeypatch.setattr(session, "_run_periods", mock.Mock())
    monkeypatch.setattr(session, "_check_heard", mock.Mock(side_effect=AssertionError))
    with pytest.raises(JudgingError, match="it uses the machine's clock"):
        session._record_baseline(trial, mock.Mock())


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
    monkeypatch.setattr(session, "_channels", lambda *_: [mock.Mock(), mock.Mock()])
    monkeypatch.setattr(signal_session, "moved_in_pauses", lambda *_: next(left))
    expected = pytest.raises(error) if error else contextlib.nullcontext()
    with expected:
        session._check_clock(mock.Mock(), mock.Mock(), 10.0)
    assert next(left, "none") == "none"


def test_notes_of_the_parameters_are_those_of_the_judgement(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, trials = session_of("parameters"), mock.Mock(notes=["not tried: /a"])
    session.evidence.baseline, session._pair = mock.Mock(), mock.Mock()
    monkeypatch.setattr(session, "_run_baseline", mock.Mock())
    monkeypatch.setattr(signal_session, "ParameterTrials", mock.Mock(return_value=trials))
    assert session.run() == ""
    assert session.notes == ["not tried: /a"]
    assert session.evidence.parameters is trials.run.return_value
