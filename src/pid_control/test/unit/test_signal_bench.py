"""Tests of the bench and the session of a coursework, without a master."""

import math
import os
import threading
from typing import Any, List
from unittest import mock

import pytest
import rosgraph
import rospkg
from std_msgs.msg import Float32, String

from pid_control.msg import motor_input
from pid_control.programs.node_queries import NodeTopics
from pid_control.programs.package_messages import MessageTypeError
from pid_control.runner.judging_errors import JudgingError
from pid_control.signal_judging.channels import Channel
from pid_control.signal_judging.evidence import GENERATOR, PROCESS, FailedTrial
from pid_control.signal_runner import coursework_bench, signal_bench, signal_session
from pid_control.signal_runner.coursework_bench import CourseworkBench, CourseworkRequest
from pid_control.signal_runner.signal_bench import SignalBench
from pid_control.signal_runner.signal_session import SignalSession

TIMES = [0.1 * index for index in range(50)]


def channel(field: str, values: List[float]) -> Channel:
    return Channel("/x", field, TIMES, values)


SINE = [math.sin(time) for time in TIMES]
FLAT = [1.0] * 50


def session_of(channels: List[Channel], *scenarios: str, **given: str) -> Any:
    """Return a session whose bench has these channels on each topic."""
    bench = mock.Mock()
    bench.channels.return_value = channels
    return SignalSession(mock.Mock(), scenarios, False, 60.0, given, mock.Mock(), bench)


def test_channel_of_a_node_is_found_given_or_asked_for() -> None:
    both = [channel("a", SINE), channel("b", SINE)]
    for node, option in ((GENERATOR, "--signal"), (PROCESS, "--proc-signal")):
        with pytest.raises(JudgingError, match=f"{option} TOPIC/FIELD, of /x/a, /x/b"):
            session_of(both)._channel(node, ["/x"], 0.0)
        session = session_of(both)
        session._given = {node: "x/b"}
        assert session._channel(node, ["/x"], 2.0).field == "b"
        session._given = {node: "/x"}
        assert session._channel(node, ["/x"], 0.0).field == "a"
        session._given = {node: "/x/c"}
        with pytest.raises(JudgingError, match=f"/x/c: not found; the {node} has: /x/a, /x/b"):
            session._channel(node, ["/x"], 0.0)
        session = session_of(both)
        session.evidence.baseline = mock.Mock(signal=both[0], output=both[1])
        assert session._channel(node, ["/x"], 0.0) == both[node == PROCESS]
    flat = [channel("a", FLAT), channel("b", FLAT)]
    names = [session_of(flat[:count])._channel(PROCESS, ["/x"], 0.0).name for count in (0, 1, 2)]
    assert names == ["/x", "/x/a", "/x"]


@pytest.mark.parametrize("scenarios, runs", [(["launch"], 0), (["launch", "signal"], 1)])
def test_launch_alone_needs_no_trial(
    scenarios: List[str], runs: int, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    session, run = session_of([], *scenarios), mock.Mock(return_value=False)
    monkeypatch.setattr(session, "_guarded", run)
    assert session.run() == "" and run.call_count == runs


def test_process_node_starts_first_once_both_are_known(monkeypatch: "pytest.MonkeyPatch") -> None:
    trial = mock.Mock()
    monkeypatch.setattr(signal_session, "Trial", trial)
    session = session_of([])
    session._pair = mock.Mock()
    session._trial()
    assert trial.call_args[0][2] == [session._pair.process, session._pair.generator]


@pytest.mark.parametrize("signal_hz, output_hz, is_fast", [(10, 10, False), (10, 90, True)])
def test_clock_is_too_coarse_for_a_fast_node(signal_hz: int, output_hz: int, is_fast: bool) -> None:
    session = session_of([])
    rates = (mock.Mock(), mock.Mock())
    for one, rate in zip(rates, (signal_hz, output_hz)):
        one.rate.return_value = float(rate)
    session.evidence.baseline = mock.Mock(signal=rates[0], output=rates[1])
    assert session._is_too_fast() is is_fast


def test_output_of_a_signal_that_is_no_sine_is_unknown() -> None:
    square = channel("a", [math.copysign(1.0, math.sin(4.0 * time)) for time in TIMES])
    output = channel("b", [math.sin(4.0 * time) for time in TIMES])
    features = session_of([])._features_of(square, output)
    assert features.signal.sine is not None and features.process is None


def test_coursework_bench_has_the_notes_of_the_latest_coursework_and_ends_its_master(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    bench: Any = CourseworkBench.__new__(CourseworkBench)
    bench.notes, bench._count, bench._bench, bench._master = [], 0, mock.Mock(), mock.Mock()
    bench._master.folder = "/scratch"
    generate = mock.Mock(return_value={})
    found = mock.Mock(side_effect=[mock.Mock(notes=["one"]), mock.Mock(notes=["two"])])
    session = mock.Mock(run=mock.Mock(return_value="why"), notes=["of the session"])
    monkeypatch.setattr(coursework_bench, "definitions", lambda _: {"x": "float32 y"})
    monkeypatch.setattr(coursework_bench, "package_name", lambda _: "anna")
    monkeypatch.setattr(coursework_bench, "generate", generate)
    monkeypatch.setattr(coursework_bench, "find_coursework", found)
    monkeypatch.setattr(signal_session, "SignalSession", lambda *_: session)
    for note in ("one", "two"):
        assert bench.run(CourseworkRequest("/handed_in", [], [], {}))[1] == "why"
        said = ["the messages of anna cannot be generated", note, "of the session"]
        assert bench.notes == said
    folders = [call[0][2] for call in generate.call_args_list]
    assert folders[0] != folders[1]  # generated modules of one would hide those of the other
    # Classes of a package that is built in this shell are not replaced.
    for is_built_here, is_built, path in (
        (False, False, "/scratch/messages3:/before"),
        (False, True, "/before"),
        (True, False, "/before"),
    ):
        classes = {"anna/x": mock.Mock()}
        generate.return_value, found.side_effect = classes, [mock.Mock(notes=[])]
        has_it = mock.Mock(return_value=is_built_here)
        monkeypatch.setattr(coursework_bench, "_is_built", has_it)
        before = {"PYTHONPATH": "/before"}
        bench.run(CourseworkRequest("/anna", [], [], before, is_built))
        bench._bench.use_classes.assert_called_with({} if is_built_here else classes)
        assert is_built or has_it.call_args == mock.call("/anna", "anna", classes)
        assert found.call_args[0][2] == {"PYTHONPATH": path} and bench.notes == ["of the session"]
    with monkeypatch.context() as patch, pytest.raises(MessageTypeError, match="<name> must be"):
        patch.setattr(coursework_bench, "package_name", lambda _: "../anna")
        bench.run(CourseworkRequest("/anna", [], [], {}))
    # One without messages needs none.
    generate.reset_mock()
    found.side_effect = [mock.Mock(notes=[])]
    monkeypatch.setattr(coursework_bench, "definitions", lambda _: {})
    bench.run(CourseworkRequest("/anna", [], [], {}))
    assert not generate.called and bench._bench.use_classes.call_args == mock.call({})
    bench._master.is_running.return_value = False
    found.side_effect = [mock.Mock(notes=[])]
    with pytest.raises(JudgingError, match="the judge's own master ended"):
        bench.run(CourseworkRequest("/anna", [], [], {}))
    bench._bench.close.side_effect = RuntimeError
    with pytest.raises(RuntimeError):
        bench.close()
    bench._master.close.assert_called_once_with()


def test_package_is_built_here_only_in_this_folder_with_these_messages() -> None:
    folder = rospkg.RosPack().get_path("std_msgs")
    for place, message_class, is_built in (
        (folder, Float32, True),
        ("/tmp", Float32, False),
        (folder, mock.Mock(_md5sum="0"), False),
    ):
        classes = {"std_msgs/String": String, "std_msgs/Float32": message_class}
        assert coursework_bench._is_built(place, "std_msgs", classes) is is_built
    assert not coursework_bench._is_built(folder, "std_msgs", {"std_msgs/None": Float32})
    assert not coursework_bench._is_built("/tmp", "no_such_package", {})


def test_request_has_the_environment_of_the_workspace(monkeypatch: "pytest.MonkeyPatch") -> None:
    """The package is found there too."""
    find = mock.Mock(return_value="/anna")
    monkeypatch.setattr(coursework_bench, "package_folder", find)
    monkeypatch.setattr(coursework_bench, "workspace_environment", lambda place: {"FROM": place})
    request = coursework_bench.find_request(["anna", "a.launch", "x:=1"], ["launch"], "/ws")
    assert request[:5] == ("/anna", ["a.launch", "x:=1"], ["launch"], {"FROM": "/ws"}, True)
    find.assert_called_once_with("anna", {"FROM": "/ws"})
    request = coursework_bench.find_request(["anna"], ["launch"])
    assert (request.environment, request.is_built) == (dict(os.environ), False)


def test_signal_bench_asks_a_node_for_its_own_topics(monkeypatch: "pytest.MonkeyPatch") -> None:
    bench: Any = SignalBench.__new__(SignalBench)
    master, ask = mock.Mock(), mock.Mock()
    monkeypatch.setattr("rosgraph.Master", master)
    master.return_value.lookupNode.side_effect = {"/a": "http://a"}.__getitem__
    monkeypatch.setattr(signal_bench, "ask_topics", ask)
    monkeypatch.setattr(signal_bench, "ask_links", ask)
    ask.return_value = NodeTopics({"/s": "F", "/rosout": "L"}, {"/t": "F", "/clock": "C"})
    assert bench.topics_of("/a") == ({"/s": "F"}, {"/t": "F"})
    ask.return_value = {"/t"}
    assert bench.links_of("/a") == {"/t"}
    assert {call[0][1] for call in ask.call_args_list} == {"http://a"}
    ask.side_effect = KeyError
    assert (bench.topics_of("/a"), bench.links_of("/a")) == (None, set())
    for error in (rosgraph.MasterError, OSError):
        master.return_value.lookupNode.side_effect = error
        assert (bench.topics_of("/a"), bench.links_of("/a")) == (None, set())


def test_coursework_bench_without_its_node_leaves_no_master(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    master = mock.Mock()
    monkeypatch.setattr(coursework_bench, "PrivateMaster", master)
    monkeypatch.setattr(signal_bench, "SignalBench", mock.Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        CourseworkBench()
    master.return_value.close.assert_called_once_with()


def test_signal_bench_counts_records_and_forgets(monkeypatch: "pytest.MonkeyPatch") -> None:
    bench: Any = SignalBench.__new__(SignalBench)
    bench._lock, bench._count, bench._clock = threading.Lock(), 0, mock.Mock()
    bench._messages, bench._subscriptions = {"/y": []}, {"/old": mock.Mock()}
    bench._node, bench._scope = mock.Mock(), mock.Mock()
    monkeypatch.setattr("time.monotonic", lambda: 50.0)
    for is_simulated, now in ((True, 3.0), (False, 4.0)):
        bench.use_clock(is_simulated)
        bench.set_clock(now)
        bench._on_message("/y", motor_input(0.5, 0.0))
    bench._on_message("/gone", motor_input(0.5, 0.0))
    assert bench._clock.publish.call_count == 1
    assert (bench.pop_count(), bench.pop_count()) == (3, 0)
    [value] = [one for one in bench.channels("/y") if one.field == "input"]
    assert (value.times, value.values) == ([3.0, 50.0], [0.5, 0.5])
    assert bench.channels("/gone") == []
    bench.listen({})
    assert bench.unheard() == [] and bench.channels("/y") == []


def test_signal_bench_subscribes_only_to_the_latest_topics() -> None:
    bench: Any = SignalBench.__new__(SignalBench)
    bench._lock, bench._subscriptions = threading.Lock(), {}
    bench._node, bench._scope = mock.Mock(), mock.Mock()
    before = bench._scope
    bench.use_classes({"anna/Wave": Float32})
    bench.listen({"/wave": "anna/Wave", "/text": "std_msgs/String"})
    before.close.assert_called_once_with()
    heard = bench._node.create_scope.return_value.create_subscription.call_args_list
    assert [call[0][:2] for call in heard] == [("/wave", Float32), ("/text", String)]
    bench.use_classes({})
    with pytest.raises(MessageTypeError, match=r"/wave: type not found \(anna/Wave\)"):
        bench.listen({"/wave": "anna/Wave"})


def test_repeated_record_forgets_failures_of_the_first(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    session = SignalSession(mock.Mock(), [], False, 60.0, {}, mock.Mock(), mock.Mock())
    session.evidence.broken["restart"] = FailedTrial("crash", "/generator")
    session.evidence.restart = mock.Mock()
    monkeypatch.setattr(session, "_trial", mock.MagicMock())
    monkeypatch.setattr(session, "_record_baseline", mock.Mock())
    session._repeat_baseline(mock.Mock())
    assert session.evidence.broken == {} and session.evidence.restart is None


def test_topics_that_this_process_cannot_hear_are_all_named() -> None:
    session = session_of([])
    session._bench.unheard.return_value = []
    session._check_heard()
    session._bench.unheard.return_value = ["/x", "/y"]
    with pytest.raises(JudgingError, match="/x, /y: another definition of its type"):
        session._check_heard()
