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
from pid_control.runner.judging_errors import BusyMachineError, JudgingError
from pid_control.signal_runner import signal_session
from pid_control.signal_runner import trial as trial_module
from pid_control.signal_runner.coursework import Coursework, find_coursework
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
    pair = mock.Mock(inputs={"/a": "F", "/b": "F"}, outputs={"/y": "F"}, others={"/z": "F"})
    pair.process.global_name = "/lab/processor"
    bench.links_of.return_value = {"/a", "/clock"}
    monkeypatch.setattr(trial, "_wait", lambda is_done: is_done())
    with pytest.raises(NotConnectedError, match="^/lab/processor does not receive /b$"):
        trial.connect(pair)
    bench.listen.assert_called_once_with({"/a": "F", "/b": "F", "/y": "F", "/z": "F"})
    bench.links_of.assert_called_with("/group/lab/processor")
    bench.links_of.return_value = {"/a", "/b"}
    trial.connect_again(pair)


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
    session._step = signal_session._FINEST_S
    with pytest.raises(JudgingError, match="more than 4000 messages per second; lower the rate"):
        session._is_too_fast()
