"""Tests of the bench and the session of a coursework, without a master."""

import math
import os
import threading
import xmlrpc.client
from typing import Any, List
from unittest import mock

import pytest
import rosgraph
import rospkg
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32, String

from pid_control.msg import motor_input
from pid_control.programs.node_queries import NodeTopics, ask_topics
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
        says = f"^which is the signal of the {node}\\? {option} TOPIC/FIELD, of /x/a, /x/b$"
        with pytest.raises(JudgingError, match=says):
            session_of(both)._channel(node, ["/x"], 0.0)
        session = session_of(both)
        session._given = {node: "x/b"}
        assert session._channel(node, ["/x"], 2.0) == both[1].between(2.0)
        session._bench.channels.assert_called_with("/x")
        session._given = {node: "/x"}
        assert session._channel(node, ["/x"], 0.0).field == "a"
        session._given = {node: "/x/c"}
        says = f"^/x/c: not found; the {node} has: /x/a, /x/b$"
        with pytest.raises(JudgingError, match=says):
            session._channel(node, ["/x"], 0.0)
        with pytest.raises(JudgingError, match=f"^/x/c: not found; the {node} has: none$"):
            session._channel(node, [], 0.0)
        session = session_of(both)
        session.evidence.baseline = mock.Mock(signal=both[0], output=both[1])
        assert session._channel(node, ["/x"], 2.0) == both[node == PROCESS].between(2.0)
        gone = Channel("/y", "ab"[node == PROCESS], [], [])
        chosen = {"signal": gone, "output": gone}
        session.evidence.baseline = mock.Mock(**chosen)
        assert session._channel(node, ["/x"], 0.0) == gone  # sent no more
    flat = [channel("a", FLAT), channel("b", FLAT)]
    found = [session_of(flat[:count])._channel(PROCESS, ["/x"], 0.0) for count in (0, 1, 2)]
    assert found == [Channel("/x", "", [], []), flat[0], flat[0]._replace(field="")]
    one = [channel("t", TIMES), channel("a", SINE)]
    assert session_of(one)._channel(GENERATOR, ["/x"], 1.0) == one[1].between(1.0)


def test_channels_of_both_nodes_are_of_their_own_topics() -> None:
    session = session_of([])
    session._bench.channels.side_effect = lambda topic: [channel("a", SINE)._replace(topic=topic)]
    pair = mock.Mock(inputs={"/in": "F"}, others={}, outputs={"/out": "F"})
    signal, output = session._channels(pair, 2.0)
    assert (signal.topic, output.topic, signal.times[0]) == ("/in", "/out", 2.0)
    pair.inputs, pair.others = {}, {"/other": "F"}
    assert session._channels(pair, 2.0)[0].topic == "/other"
    constant = [channel("a", FLAT), channel("b", SINE), channel("c", [9.0] * 20 + [3.0] * 30)]
    constant.append(Channel("/x", "d", [], []))
    session = session_of(constant)
    assert session._constants(constant[1], 2.0) == {"a": 1.0, "c": 3.0}
    session._bench.channels.assert_called_once_with("/x")


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
    coursework, master, bench = mock.Mock(), mock.Mock(), mock.Mock()
    monkeypatch.setattr("time.monotonic", lambda: 100.0)
    for real_time in (False, True):
        session: Any = SignalSession(coursework, [], real_time, 60.0, {}, master, bench)
        assert session.evidence.missing is coursework.missing
        session._trial()
        given = bench, master, coursework.nodes, coursework.parameters, 160.0, not real_time
        trial.assert_called_with(*given, "", 0.01)
        session._pair, session._step = mock.Mock(), 0.002
        session._trial({"/a": 1}, group="/b")
        nodes = [session._pair.process, session._pair.generator]
        trial.assert_called_with(bench, master, nodes, {"/a": 1}, 160.0, not real_time, "/b", 0.002)
        session._trial({})
        assert trial.call_args[0][3] == {}


@pytest.mark.parametrize(
    "signal_hz, output_hz, is_fast",
    [(10, 10, False), (10, 90, True), (90, 10, True), (79, 79, False), (80, 0, True)],
)
def test_clock_is_too_coarse_for_a_fast_node(signal_hz: int, output_hz: int, is_fast: bool) -> None:
    session = session_of([])
    rates = (mock.Mock(), mock.Mock())
    for one, rate in zip(rates, (signal_hz, output_hz)):
        one.rate.return_value = float(rate) or None
    session.evidence.baseline = mock.Mock(signal=rates[0], output=rates[1])
    assert session._is_too_fast() is is_fast


def test_output_of_a_signal_that_is_no_sine_is_unknown() -> None:
    square = channel("a", [math.copysign(1.0, math.sin(4.0 * time)) for time in TIMES])
    output = channel("b", [math.sin(4.0 * time) for time in TIMES])
    features = session_of([])._features_of(square, output)
    assert features.signal.sine is not None and features.process is None
    assert session_of([])._features_of(channel("a", FLAT), output).process is None
    signal = channel("a", [2.0 * math.sin(4.0 * time) for time in TIMES])
    features = session_of([])._features_of(signal, output)
    assert features.process is not None and features.process.gain == pytest.approx(0.5)


def test_coursework_bench_has_the_notes_of_the_latest_coursework_and_ends_its_master(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    master, made = mock.Mock(folder="/scratch"), mock.Mock()
    monkeypatch.setattr(coursework_bench, "PrivateMaster", mock.Mock(return_value=master))
    monkeypatch.setattr(signal_bench, "SignalBench", mock.Mock(return_value=made))
    bench: Any = CourseworkBench()
    assert (bench.notes, bench._bench, bench._master) == ([], made, master)
    generate = mock.Mock(return_value={})
    found = mock.Mock(side_effect=[mock.Mock(notes=["one"]), mock.Mock(notes=["two"])])
    session = mock.Mock(run=mock.Mock(return_value="why"), notes=["of the session"])
    make = mock.Mock(return_value=session)
    texts = {"/handed_in": {"x": "float32 y"}, "/anna": {"x": "float32 y"}}
    names = {"/handed_in": "anna", "/anna": "anna"}
    monkeypatch.setattr(coursework_bench, "definitions", lambda folder: texts[folder])
    monkeypatch.setattr(coursework_bench, "package_name", lambda folder: names[folder])
    monkeypatch.setattr(coursework_bench, "generate", generate)
    monkeypatch.setattr(coursework_bench, "find_coursework", found)
    monkeypatch.setattr(signal_session, "SignalSession", make)
    for note in ("one", "two"):
        given: Any = {"signal generator": "/x"}
        request = CourseworkRequest("/handed_in", ["a"], ["signal"], {"A": "1"})
        request = request._replace(programs=["p"], real_time=True, time_limit=9.0, given=given)
        assert bench.run(request) == (session.evidence, "why")
        said = ["the messages of anna cannot be generated", note, "of the session"]
        assert bench.notes == said
        assert found.call_args == mock.call("/handed_in", ["a"], mock.ANY, ["p"])
        assert make.call_args[0][1:] == (["signal"], True, 9.0, given, master, made)
        assert make.call_args[0][0].notes == [note]
    # Generated modules of one would hide those of the other.
    assert generate.call_args_list == [
        mock.call("anna", texts["/handed_in"], f"/scratch/messages{number}") for number in (1, 2)
    ]
    assert (request.environment, CourseworkRequest("", [], [], {})[4:]) == (
        {"A": "1"},
        (False, (), False, 120.0, {}),
    )
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
        assert before == {"PYTHONPATH": "/before"}
        bench._bench.use_classes.assert_called_with({} if is_built_here else classes)
        assert is_built or has_it.call_args == mock.call("/anna", "anna", classes)
        assert found.call_args[0][2] == {"PYTHONPATH": path} and bench.notes == ["of the session"]
    with monkeypatch.context() as patch, pytest.raises(MessageTypeError, match="<name> must be"):
        patch.setitem(names, "/anna", "../anna")
        bench.run(CourseworkRequest("/anna", [], [], {}))
    # One without messages needs none.
    generate.reset_mock()
    found.side_effect = [mock.Mock(notes=[])]
    texts["/anna"] = {}
    names["/anna"] = "../anna"
    bench.run(CourseworkRequest("/anna", [], [], {}))
    assert not generate.called and bench._bench.use_classes.call_args == mock.call({})
    bench._master.is_running.return_value = False
    found.side_effect = [mock.Mock(notes=[])]
    says = r"^the judge's own master ended; is this machine out of memory\?$"
    with pytest.raises(JudgingError, match=says):
        bench.run(CourseworkRequest("/anna", [], [], {}))
    # An error leaves the notes so far.
    session.run.side_effect = JudgingError
    found.side_effect = [mock.Mock(notes=["three"])]
    with pytest.raises(JudgingError):
        bench.run(CourseworkRequest("/anna", [], [], {}))
    assert bench.notes == ["three", "of the session"]
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
    own = {"/rosout": "L", "/rosout_agg": "L", "/clock": "C"}
    ask.return_value = NodeTopics({"/s": "F", **own}, {"/t": "F", **own})
    assert bench.topics_of("/a") == ({"/s": "F"}, {"/t": "F"})
    ask.return_value = {"/t"}
    assert bench.links_of("/a") == {"/t"}
    assert ask.call_args_list == [mock.call("judge", "http://a")] * 2
    master.assert_called_with("judge")
    ask.side_effect = KeyError
    assert (bench.topics_of("/a"), bench.links_of("/a")) == (None, set())
    for error in (rosgraph.MasterError, OSError, xmlrpc.client.Fault(0, "")):
        master.return_value.lookupNode.side_effect = error
        assert (bench.topics_of("/a"), bench.links_of("/a")) == (None, set())


def test_ask_topics_returns_what_a_node_publishes_and_subscribes_to(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    connect = mock.MagicMock()
    node = connect.return_value.__enter__.return_value
    node.getPublications.return_value = 1, "", [["/s", "F"]]
    node.getSubscriptions.return_value = 1, "", [["/t", "G"], ["/u", "H"]]
    monkeypatch.setattr("xmlrpc.client.ServerProxy", connect)
    assert ask_topics("/judge", "http://a") == ({"/s": "F"}, {"/t": "G", "/u": "H"})
    assert connect.call_args[0] == ("http://a",)
    assert node.mock_calls[:2] == [
        mock.call.getPublications("/judge"),
        mock.call.getSubscriptions("/judge"),
    ]


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
    node = mock.Mock()
    make = mock.Mock(return_value=node)
    monkeypatch.setattr(signal_bench, "init_node", make)
    bench: Any = SignalBench()
    make.assert_called_once_with("judge")
    assert node.mock_calls == [
        mock.call.create_publisher("/clock", Clock),
        mock.call.start(),
        mock.call.create_scope(),
    ]
    node.create_publisher.return_value.get_num_connections.return_value = 3
    assert bench.clock_listeners() == 3
    # Before a clock is chosen, it is simulated.
    bench._on_message("/y", motor_input(0.5, 0.0))
    bench.set_clock(2.5)
    assert bench._clock.publish.call_args == mock.call(Clock(rospy.Time(2, 500_000_000)))
    bench._clock.publish.reset_mock()
    bench.listen({"/y": "pid_control/motor_input"})
    assert bench.pop_count() == 1 and bench.channels("/y") == []
    monkeypatch.setattr("time.monotonic", lambda: 50.0)
    for is_simulated, now in ((True, 3.0), (False, 4.0)):
        bench.use_clock(is_simulated)
        bench.set_clock(now)
        bench._on_message("/y", motor_input(0.5, 0.0))
    bench._on_message("/gone", motor_input(0.5, 0.0))
    assert bench._clock.publish.call_args_list == [mock.call(Clock(rospy.Time(3)))]
    assert (bench.pop_count(), bench.pop_count()) == (3, 0)
    assert bench.channels("/y") == [
        Channel("/y", "input", [3.0, 50.0], [0.5, 0.5]),
        Channel("/y", "time", [3.0, 50.0], [0.0, 0.0]),
    ]
    assert bench.channels("/gone") == []
    scope = node.create_scope.return_value
    links = [mock.Mock(get_num_connections=lambda one=one: one) for one in (0, 1, 0)]
    scope.create_subscription.side_effect = links
    bench.listen(dict.fromkeys(["/a", "/b", "/c"], "std_msgs/String"))
    assert bench.unheard() == ["/a", "/c"]
    bench.listen({})
    assert bench.unheard() == [] and bench.channels("/y") == []
    shut_down = mock.Mock()
    monkeypatch.setattr("rospy.signal_shutdown", shut_down)
    bench.close()
    shut_down.assert_called_once_with("the judgement is complete")


def test_signal_bench_subscribes_only_to_the_latest_topics() -> None:
    bench: Any = SignalBench.__new__(SignalBench)
    bench._lock, bench._subscriptions, bench._count = threading.Lock(), {}, 0
    bench._node, bench._scope = mock.Mock(), mock.Mock()
    bench._is_simulated, bench._now = True, 1.5
    before = bench._scope
    bench.use_classes({"anna/Wave": Float32})
    bench.listen({"/wave": "anna/Wave", "/text": "std_msgs/String"})
    before.close.assert_called_once_with()
    heard = bench._node.create_scope.return_value.create_subscription.call_args_list
    assert [call[0][:2] for call in heard] == [("/wave", Float32), ("/text", String)]
    heard[0][0][2](Float32(0.5))
    assert bench.channels("/wave") == [Channel("/wave", "data", [1.5], [0.5])]
    assert bench.channels("/text") == []
    bench.use_classes({})
    with pytest.raises(MessageTypeError, match=r"/wave: type not found \(anna/Wave\)"):
        bench.listen({"/wave": "anna/Wave"})


def test_repeated_record_forgets_failures_of_the_first(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    session = SignalSession(mock.Mock(), [], False, 60.0, {}, mock.Mock(), mock.Mock())
    session.evidence.broken["restart"] = FailedTrial("crash", "/generator")
    session.evidence.restart = session.evidence.baseline = mock.Mock()
    make, record, pair = mock.MagicMock(), mock.Mock(), mock.Mock()
    monkeypatch.setattr(session, "_trial", make)
    monkeypatch.setattr(session, "_record_baseline", record)
    assert session._repeat_baseline(pair) is record.return_value
    trial = make.return_value.__enter__.return_value
    trial.start.assert_called_once_with()
    record.assert_called_once_with(trial, pair)
    assert session.evidence.broken == {} and session.evidence.restart is None
    assert session.evidence.baseline is None


def test_topics_that_this_process_cannot_hear_are_all_named() -> None:
    session = session_of([])
    session._bench.unheard.return_value = []
    session._check_heard()
    session._bench.unheard.return_value = ["/x", "/y"]
    says = "^/x, /y: another definition of its type than the judge's$"
    with pytest.raises(JudgingError, match=says):
        session._check_heard()
    session._check_lateness(mock.Mock(latest=0.1))
    with pytest.raises(JudgingError) as error:
        session._check_lateness(mock.Mock(latest=0.1004))
    says = "this machine is too busy: the judge itself was 0.100 s late"
    assert str(error.value) == says
