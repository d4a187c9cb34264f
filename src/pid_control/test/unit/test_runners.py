"""Runners of submissions, without their processes."""

import itertools
import threading
from typing import Any, Dict, List, Optional
from unittest import mock

import pytest
import rosgraph
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32

from pid_control.judging.experiment import Experiment, MotorOutput, OutgoingMessages
from pid_control.judging.record import (
    ENDED,
    NOT_CONNECTED,
    RESTLESS,
    SILENT,
    Pause,
    Record,
    Row,
)
from pid_control.judging.scenarios import BY_NAME, SLOW_STEP_S, STEP_S
from pid_control.msg import motor_input, motor_output
from pid_control.programs.package_messages import MessageTypeError
from pid_control.programs.program_command import ProgramCommand
from pid_control.runner import bench_runner, clock, gains_judgement, test_bench
from pid_control.runner.bench_runner import BenchRunner
from pid_control.runner.gains_judgement import judge_gains
from pid_control.runner.judging_errors import BusyMachineError, JudgingError, TimeLimitExceeded
from pid_control.runner.loop_messages import course_messages, loop_message
from pid_control.runner import session as session_module
from pid_control.runner.session import Session
from pid_control.runner.student_messages import StudentMessages
from pid_control.tuning.rules import Gains
from played import pi, play_one


def test_answers_in_the_first_half_of_a_pause_count_as_late(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    now = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda seconds: now.append(now.pop() + seconds))
    watch = mock.Mock()
    watch.is_idle.return_value = True
    simulated = clock.SimulatedClock(watch)
    simulated.start()
    pause = simulated.pause(7.0, mock.Mock(side_effect=[9, 4]))
    assert pause == Pause(7.0, pytest.approx(0.25, abs=0.005), 1.0, 4)
    watch.is_idle.side_effect = itertools.cycle([False, True])
    counts, counted_at = iter([5, 1]), []

    def count() -> int:
        counted_at.append(now[0])
        return next(counts)

    begin = now[0]
    longer = simulated.pause(8.0, count)
    assert counted_at == pytest.approx([begin + 0.25, begin + 0.5], abs=0.005)
    half = pytest.approx(0.5, abs=0.01)
    assert longer == Pause(8.0, pytest.approx(2.0 * pause.length, abs=0.005), half, 1)
    # A thread that waits for a processor is not idle, but computes nothing.
    watch.is_idle.side_effect = itertools.cycle([False, False, False, True])
    watch.has_run.side_effect = itertools.cycle([False, True, False, False])
    assert simulated.pause(9.0, mock.Mock()).rest == pytest.approx(0.5, abs=0.01)
    watch.is_idle.side_effect, watch.has_run.side_effect = lambda: False, lambda: False
    assert simulated.pause(10.0, mock.Mock()).rest == 1.0
    # On a busy machine a scenario takes longer, and so does a first pause.
    simulated.start()
    simulated._paused, now[0] = 0.0, now[0] + 10.0
    long = simulated.pause(0.0, mock.Mock(return_value=0)).length
    assert long == pytest.approx(0.5 * 10.0, abs=0.005)
    assert simulated.wait(0.1) is watch.wait_idle.return_value
    watch.wait_idle.assert_called_once_with(2.0)


@pytest.mark.parametrize("is_roscpp", [False, True])
def test_step_of_the_clock_is_as_long_as_the_interval_in_which_roscpp_looks_at_it(
    is_roscpp: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    watch, calls = mock.Mock(), mock.Mock()
    watch.has_library = lambda name: is_roscpp and name == "libroscpp.so"
    monkeypatch.setattr("time.sleep", calls.sleep)
    calls.attach_mock(watch.wait_idle, "wait_idle")
    simulated = clock.SimulatedClock(watch)
    simulated.start()
    simulated.wait(0.1)
    slept = [mock.call.sleep(0.0013)] if is_roscpp else []
    assert calls.mock_calls == [*slept, mock.call.wait_idle(2.0)]


def test_wall_clock_keeps_its_largest_delay(monkeypatch: "pytest.MonkeyPatch") -> None:
    wall = clock.WallClock()
    sleep = mock.Mock()
    monkeypatch.setattr("time.sleep", sleep)
    monkeypatch.setattr("time.monotonic", iter([5.0, 5.75, 6.0, 9.0]).__next__)
    wall.start()
    assert [wall.wait(until) for until in (0.5, 2.0, 4.0)] == [True] * 3
    assert wall.latest == 0.25
    sleep.assert_called_once_with(1.0)  # until the second step; it is late for the first
    assert wall.pause(1.0, mock.Mock()) is None


class BenchRig:
    """Runner on a bench without ROS, whose controller connects at once."""

    def __init__(self, patch: "pytest.MonkeyPatch", real_time: bool = False) -> None:
        self.parameters: Dict[str, Any] = {}
        patch.setattr("rospy.set_param", self.parameters.__setitem__)
        self.bench, self.clock = mock.Mock(), mock.Mock()
        self.bench.is_connected.return_value = False
        self.bench.pop_inputs.return_value = []
        self.process = mock.Mock(status=None, writes_without_end=False)
        self.process.watch.busy.return_value = 0.0
        self.process.last_words.return_value = ""
        self.start, self.clock_of = mock.Mock(return_value=self.process), mock.Mock()
        self.clock_of.return_value = self.clock
        patch.setattr(bench_runner, "ProgramProcess", self.start)
        patch.setattr(bench_runner, "SimulatedClock", self.clock_of)
        patch.setattr(BenchRunner, "_connect", lambda *_: True)
        given, others = {"/a": 1}, {"/a": 2, "/b": 3}
        command = ProgramCommand("x", ["x"], {}, given, others)
        self.begin = mock.call(command, {"ROS_MASTER_URI": "m"}, [77])
        environment = {"ROS_MASTER_URI": "m"}
        self.runner = BenchRunner(self.bench, command, environment, real_time, float("inf"), 77)

    def run(self, **changes: Any) -> Record:
        return self.runner.run(BY_NAME["ramp"]._replace(duration=0.01, **changes))


@pytest.mark.parametrize("real_time", [False, True])
def test_parameters_of_the_controller_and_of_its_launch_file_are_set(
    real_time: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    rig = BenchRig(monkeypatch, real_time)
    assert rig.parameters == {"/a": 1, "/b": 3, "/use_sim_time": not real_time}


def test_each_scenario_has_its_own_controller_clock_and_figures(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    rig = BenchRig(monkeypatch)
    for number in range(2):
        rig.process.watch.busy.side_effect = [5.0, 5.75]
        rig.bench.pop_inputs.side_effect = itertools.chain([[9.0]], itertools.repeat([0.5]))
        rig.bench.send.reset_mock()
        rig.clock.pause.side_effect = lambda time, count: Pause(time, 1.0, 1.0, 0)
        rig.clock.wait.reset_mock()
        record = rig.run(pauses=(0.002, 0.006))
        times = [round(-0.1 + STEP_S * step, 9) for step in range(55)]
        assert record == Record(
            BY_NAME["ramp"]._replace(duration=0.01, pauses=(0.002, 0.006)),
            rows=[
                Row(pytest.approx(time), 0.0, pytest.approx(speed, abs=1e-3), 0.5)
                for time, speed in zip(times[50:], (0.0, 0.319, 0.623, 0.912, 1.187))
            ],
            answers=[(pytest.approx(time, abs=1e-9), 0.5) for time in times],  # not one of before
            busy=0.75,
            is_simulated=True,
            pauses=[Pause(pytest.approx(time, abs=1e-9), 1.0, 1.0, 0) for time in (0.0, 0.004)],
        )
        waits = [call[0][0] for call in rig.clock.wait.call_args_list]
        assert waits == pytest.approx([STEP_S * step for step in range(1, 56)])
        assert rig.process.end.call_count == rig.clock.start.call_count == number + 1
        sent = [call[0][1] for call in rig.bench.send.call_args_list]
        assert sent == pytest.approx([0.01 + STEP_S * step for step in range(55)])
    assert rig.start.call_args_list == [rig.begin] * 2
    assert rig.clock_of.call_args_list == [mock.call(rig.process.watch)] * 2
    assert rig.bench.check_publishers.call_count == 2


@pytest.mark.parametrize("status, failure", [(1, ENDED), (None, NOT_CONNECTED)])
def test_controller_that_does_not_connect_has_ended_or_other_topics(
    status: Optional[int], failure: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    rig = BenchRig(monkeypatch)
    monkeypatch.setattr(BenchRunner, "_connect", lambda *_: False)
    rig.process.status = status
    rig.runner.notes.append("its types are used")  # only once
    rig.process.last_words.return_value = "bye"
    rig.bench.missing.return_value, rig.bench.hint.return_value = ["set_point"], "it has /r"
    ramp = BY_NAME["ramp"]._replace(duration=0.01)
    assert rig.run() == Record(ramp, failure, "bye", ["set_point"], "it has /r", is_simulated=True)
    assert not rig.bench.follow.called and not rig.bench.check_publishers.called
    rig.process.end.assert_called_once_with()


def test_controller_with_other_types_is_run_again_with_them(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    rig = BenchRig(monkeypatch)
    connects = iter([False, True])
    monkeypatch.setattr(BenchRunner, "_connect", lambda *_: next(connects))
    rig.bench.messages = course_messages()
    types = {"/set_point": "std_msgs/Float32", "/u": "x/Y", "/motor_input": "no_such/Type"}
    rig.bench.types_of_controller.return_value = types
    assert rig.run().failure != NOT_CONNECTED
    [(messages,)] = [call[0] for call in rig.bench.follow.call_args_list]
    assert messages["set_point"] == loop_message("set_point", Float32)
    assert {**messages, "set_point": None} == {**course_messages(), "set_point": None}
    [note] = rig.runner.notes
    assert note.startswith("set_point is std_msgs/Float32 with (float32 data), in the course")


@pytest.mark.parametrize(
    "types, silent, says",
    [
        ({"/clock": "C", "/rosout": "L"}, [], ""),
        (
            {"/clock": "C", "/rosout": "L"},
            ["/a", "/b"],
            "its types are unknown: /a, /b does not answer",
        ),
        ({"/u": "F", "/clock": "C", "/a": "F"}, ["/b"], "it has the topics /a, /u"),
        ({"/set_point": "F"}, [], "its set_point is F, not pid_control/set_point"),
        (
            {"/set_point": "pid_control/set_point"},
            [],
            "its set_point has another definition of pid_control/set_point than the judge",
        ),
        ({"/rosout_agg": "L", "/motor_output": "F"}, [], ""),
        ({"/motor_output": "F"}, [], ""),
    ],
)
def test_hint_of_the_test_bench_names_types_and_topics_of_the_controller(
    types: Dict[str, str], silent: List[str], says: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    bench: Any = test_bench.TestBench.__new__(test_bench.TestBench)
    bench.messages = course_messages()
    monkeypatch.setattr(bench, "_types", lambda: (types, silent))
    monkeypatch.setattr(bench, "missing", lambda: ["set_point", "motor_input"])
    hint = bench.hint()
    assert hint == says


def test_controller_without_a_motor_has_the_time_that_it_needed_with_one(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    connect = BenchRunner._connect
    rig = BenchRig(monkeypatch)
    rig.bench.missing.return_value = []
    rig.bench.pop_inputs.side_effect = [[], [], [], [0.5]]
    monkeypatch.setattr("time.sleep", mock.Mock())
    assert connect(rig.runner, Experiment(BY_NAME["steps"], 0.01), rig.process)
    needed = rig.runner._clock
    assert needed == pytest.approx(0.01 + 3 * STEP_S)
    sent = [call[0] for call in rig.bench.send.call_args_list]
    assert [clock for _, clock in sent] == pytest.approx([0.01, 0.012, 0.014])
    assert [message.output.time for message, _ in sent] == pytest.approx([0.0, 0.002, 0.004])
    assert rig.process.watch.wait_idle.call_args_list == [mock.call(0.1)] * 3
    assert rig.runner._patience(Experiment(BY_NAME["early"], 0.0)) == needed
    assert rig.runner._patience(Experiment(BY_NAME["steps"], 0.0)) == 10.0
    # One that never answers is connected: its scenario shows that it is silent.
    monkeypatch.setattr(bench_runner, "_FIRST_ANSWER_S", 0.02)
    rig.bench.pop_inputs.side_effect = itertools.repeat([])
    assert connect(rig.runner, Experiment(BY_NAME["steps"], 0.0), rig.process)
    rig.runner._deadline = 0.0
    for late in (lambda: connect(rig.runner, mock.Mock(), rig.process), rig.run):
        with pytest.raises(TimeLimitExceeded):
            late()


def test_controller_that_ends_or_has_other_topics_does_not_connect(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    connect = BenchRunner._connect
    rig = BenchRig(monkeypatch)
    monkeypatch.setattr("time.sleep", mock.Mock())
    experiment = Experiment(BY_NAME["steps"], 0.0)
    rig.bench.missing.return_value = ["set_point"]
    rig.process.status = 1
    assert not connect(rig.runner, experiment, rig.process)
    rig.process.status = None
    now = itertools.count(0.0, 0.5)
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    busy = itertools.chain(itertools.repeat(19.0, 50), itertools.repeat(21.0))
    rig.process.watch.busy.side_effect = lambda: next(busy)
    # The second topic has less time; a machine that is busy with the controller gives it more.
    for is_connected, is_idle, least in (
        (False, True, 20.0),
        (True, True, 5.0),
        (True, False, 25.0),
    ):
        rig.bench.is_connected.return_value = is_connected
        rig.process.watch.is_idle.return_value = is_idle
        begin = next(now)
        assert not connect(rig.runner, experiment, rig.process)
        assert least <= next(now) - begin <= least + 3.0 + 30.0 * (not is_idle)
    # Connections of an ended controller are found to be dead only by writing to them.
    rig.bench.send.reset_mock()
    rig.bench.is_connected.side_effect = [True, True, False]
    rig.runner._wait_until_alone()
    rest = OutgoingMessages(0.0, MotorOutput(0.0, 0.0, "Motor Not Turning"))
    assert rig.bench.send.call_args_list == [mock.call(rest, rig.runner._clock)] * 2
    rig.bench.is_connected.side_effect = itertools.repeat(True)
    rig.runner._wait_until_alone()  # not forever


@pytest.mark.parametrize(
    "real_time, has_clock, waited",
    [(False, False, 1.0), (False, True, 0.0), (True, False, 0.0)],
)
def test_controller_without_clock_begins_after_a_second(
    real_time: bool, has_clock: bool, waited: float, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    """It may still subscribe to the clock, which stands until then."""
    connect = BenchRunner._connect
    rig = BenchRig(monkeypatch, real_time)
    now = [50.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])

    def sleep(seconds: float) -> None:
        assert seconds == STEP_S and now[0] < 60.0
        now[0] += seconds

    monkeypatch.setattr("time.sleep", sleep)
    rig.bench.missing.return_value = []
    rig.bench.has_clock_listener.return_value = has_clock
    rig.bench.pop_inputs.return_value = [0.5]
    assert connect(rig.runner, Experiment(BY_NAME["steps"], 0.0), rig.process)
    assert now[0] - 50.0 == pytest.approx(waited, abs=0.01)
    assert {call[0][1] for call in rig.bench.send.call_args_list} <= {0.01}


def test_silent_controller_fails_with_its_last_words(monkeypatch: "pytest.MonkeyPatch") -> None:
    rig = BenchRig(monkeypatch)
    rig.process.last_words.return_value = "waiting"
    rig.bench.is_connected.side_effect = [True, False]  # the controller before it
    record = rig.runner.run(BY_NAME["ramp"]._replace(duration=0.6))
    assert rig.bench.is_connected.call_count == 2
    assert (record.failure, record.words) == (SILENT, "waiting")


def test_clock_of_the_bench_is_slow_where_the_scenario_says_so(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    rig = BenchRig(monkeypatch)
    rig.runner.run(BY_NAME["ramp"]._replace(duration=0.2, slow=(0.0, 0.2)))
    times = [call[0][1] for call in rig.bench.send.call_args_list]
    steps = [after - before for before, after in zip(times, times[1:])]
    assert steps[-3:] == pytest.approx([STEP_S, SLOW_STEP_S, SLOW_STEP_S])


def test_controller_that_sends_without_a_pause_is_never_idle(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    detector = mock.Mock()
    monkeypatch.setattr(bench_runner, "BusyDetector", lambda _: detector)
    detector.is_its_own.side_effect = [False, True]
    rig = BenchRig(monkeypatch)
    rig.clock.wait.return_value = False
    rig.bench.pop_inputs.side_effect = [[], [0.0] * 100, [0.0] * 99]
    assert rig.run().failure == RESTLESS
    assert detector.update.call_args_list == [mock.call(False, True), mock.call(False, False)]


def test_lateness_of_the_judge_is_that_of_its_worst_scenario(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    late = iter([0.5, 0.1])

    class LateClock(clock.WallClock):
        """Clock with the next delay of the list."""

        def start(self) -> None:
            self.latest = next(late)

        def wait(self, until: float) -> bool:
            return True

    monkeypatch.setattr("rospy.set_param", mock.Mock())
    monkeypatch.setattr(bench_runner, "WallClock", LateClock)
    bench, process = mock.Mock(), mock.Mock(status=None, writes_without_end=False)
    bench.is_connected.return_value = False
    bench.pop_inputs.return_value = []
    process.watch.busy.return_value = 0.0
    monkeypatch.setattr(bench_runner, "ProgramProcess", lambda *_: process)
    monkeypatch.setattr(BenchRunner, "_connect", lambda *_: True)
    command = ProgramCommand("x", ["x"], {}, {}, {})
    runner = BenchRunner(bench, command, {}, True, float("inf"), 0)
    for _ in range(2):
        assert not runner.run(BY_NAME["ramp"]._replace(duration=0.01)).is_simulated
    assert runner.latest == 0.5 and next(late, None) is None
    assert runner.most_late == 0.02


def test_test_bench_follows_other_types_on_all_topics() -> None:
    bench: Any = test_bench.TestBench.__new__(test_bench.TestBench)
    bench._lock, bench._inputs, bench.node = threading.Lock(), [0.5], mock.Mock()
    before = mock.Mock(), mock.Mock(), mock.Mock()
    bench._output, bench._set_point, bench._input = before
    own = {**course_messages(), "set_point": loop_message("set_point", Float32)}
    bench.follow(own)
    for one in before:
        one.close.assert_called_once_with()
    assert bench.messages is own
    assert bench.node.mock_calls == [
        mock.call.create_publisher("/motor_output", motor_output),
        mock.call.create_publisher("/set_point", Float32),
        mock.call.create_subscription("/motor_input", motor_input, bench._on_input),
    ]
    assert bench._input is bench.node.create_subscription.return_value
    assert bench.pop_inputs() == [0.5] and bench.pop_inputs() == []
    for value in (0.25, 0.75):
        bench._on_input(motor_input(value, 0.0))
    assert bench.pop_inputs() == [0.25, 0.75]


def test_test_bench_sends_the_clock_after_the_messages_of_that_time(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    """A loop that wakes by the clock answers them."""
    node, sent = mock.MagicMock(), []
    monkeypatch.setattr(test_bench, "init_node", lambda name: {"judge": node}[name])
    node.create_publisher.side_effect = lambda topic, kind: mock.Mock(
        publish=lambda message: sent.append((topic, message))
    )
    own = {**course_messages(), "set_point": loop_message("set_point", Float32)}
    bench = test_bench.TestBench(own)
    assert [call[0] for call in node.method_calls] == [
        "create_publisher",
        "create_publisher",
        "create_publisher",
        "create_subscription",
        "start",
    ]
    assert (bench.messages, test_bench.TestBench().messages) == (own, course_messages())
    bench.send(OutgoingMessages(3.0, MotorOutput(2.0, 0.5, "Motor Turning")), 1.25)
    bench.send(OutgoingMessages(None, None), 1.5)
    assert sent == [
        ("/set_point", Float32(3.0)),
        ("/motor_output", motor_output(2.0, 0.5, "Motor Turning")),
        ("/clock", Clock(rospy.Time.from_sec(1.25))),
        ("/clock", Clock(rospy.Time.from_sec(1.5))),
    ]


def test_test_bench_asks_the_other_nodes_for_their_types(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    bench: Any = test_bench.TestBench.__new__(test_bench.TestBench)
    master, ask = mock.Mock(), mock.Mock(return_value=({"/u": "F"}, ["/b"]))
    publishers, subscribers = [["/u", ["/a", "/judge"]]], [["/y", ["/b", "/gone"]]]
    master.getSystemState.return_value = [1, "", [publishers, subscribers, [["/s", ["/c"]]]]]
    monkeypatch.setattr("rospy.get_master", lambda: master)
    monkeypatch.setattr("rospy.get_name", lambda: "/judge")
    known = {"/a": "http://a", "/b": "http://b", "/judge": "http://judge"}

    def look_up(node: str) -> str:
        if node not in known:
            raise rosgraph.MasterError("unknown node")
        return known[node]

    monkeypatch.setattr("rosgraph.Master", lambda _: mock.Mock(lookupNode=look_up))
    monkeypatch.setattr(test_bench, "ask_types", ask)
    assert bench.types_of_controller() == {"/u": "F"}
    ask.assert_called_once_with({"/a": "http://a", "/b": "http://b"})
    shutdown = mock.Mock()
    monkeypatch.setattr("rospy.signal_shutdown", shutdown)
    bench.close()
    shutdown.assert_called_once_with("the judgement is complete")


def test_test_bench_names_the_topics_without_a_connection() -> None:
    bench: Any = test_bench.TestBench.__new__(test_bench.TestBench)
    topics = ["motor_output", "set_point", "motor_input", "clock"]
    ends = [mock.Mock() for _ in topics]
    bench._output, bench._set_point, bench._input, bench._clock = ends
    for index, topic in enumerate(topics):
        for one in ends:
            one.get_num_connections.return_value = int(one is ends[index])
        assert bench.missing() == [name for name in topics[:3] if name != topic]
        assert (bench.is_connected(), bench.has_clock_listener()) == (index < 3, index == 3)


@pytest.mark.parametrize("topic", ["/set_point", "/motor_output"])
def test_test_bench_refuses_another_publisher(
    topic: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    bench: Any = test_bench.TestBench.__new__(test_bench.TestBench)
    master = mock.Mock()
    monkeypatch.setattr("rospy.get_master", lambda: master)
    monkeypatch.setattr("rospy.get_name", lambda: "/judge")
    master.getSystemState.return_value = [1, "", [[[topic, ["/judge"]], ["/u", ["/a"]]], [], []]]
    bench.check_publishers()
    for others in (["/a"], ["/a", "/b"]):
        master.getSystemState.return_value = [1, "", [[[topic, ["/judge", *others]]], [], []]]
        says = f"^{' and '.join(others)} publishes {topic[1:]}, like the judge; remove that$"
        with pytest.raises(test_bench.PublisherConflict, match=says):
            bench.check_publishers()


def session_of(latest: float, *records: Record) -> Any:
    """Return a session whose runner returns these records, after a call of _run."""
    session: Any = Session(ProgramCommand("x", ["x"], {}, {}, {}), None, {}, 60.0)
    runner = mock.Mock(latest=latest, most_late=0.02)
    runner.run.side_effect = records
    session._run(runner, [BY_NAME[record.scenario.name] for record in records])
    session.ran = [call[0][0] for call in runner.run.call_args_list]
    return session


def test_session_adapts_a_scenario_to_the_answers_before() -> None:
    held = play_one("held", pi(kp=0.7, ki=73.0))
    ran = session_of(0.0, held, play_one("rate", pi())).ran
    assert ran[0] == BY_NAME["held"]
    assert max(ran[1].set_point) < max(BY_NAME["rate"].set_point)


@pytest.mark.parametrize("is_running", [True, False])
def test_session_with_its_own_plant_has_all_notes_and_leaves_nothing(
    is_running: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    master, runner, bench = mock.Mock(), mock.Mock(), mock.Mock()
    master.return_value.is_running.return_value = is_running
    master.return_value.folder = "/scratch"
    runner.return_value = mock.Mock(latest=0.0, most_late=0.02, notes=["followed"])
    runner.return_value.run.return_value = Record(BY_NAME["ramp"], ENDED)
    command = ProgramCommand("x", ["x"], {}, {}, {}, notes=["found"])
    classes: Dict[str, Any] = {"x/Y": None}
    known = command._replace(notes=["found", "own"])
    own = StudentMessages(known, classes, {"a": "own", "b": "own"})
    read = mock.Mock(return_value=own)
    monkeypatch.setattr("time.monotonic", lambda: 100.0)
    monkeypatch.setattr(session_module, "PrivateMaster", master)
    monkeypatch.setattr(session_module, "read_messages", read)
    monkeypatch.setattr(session_module, "given_message", lambda *words: words)
    monkeypatch.setattr(bench_runner, "BenchRunner", runner)
    monkeypatch.setattr(test_bench, "TestBench", bench)
    session = Session(command, [BY_NAME["ramp"]], {}, 60.0, {"b": "given"})
    if is_running:
        assert session.judge_with_own_plant(False).flaws() == ["crash"]
        bench.return_value.close.assert_called_once_with()
    else:
        says = "the judge's own master ended; is this machine out of memory?"
        with pytest.raises(JudgingError, match=says):
            session.judge_with_own_plant(False)
    read.assert_called_once_with(command, "/scratch/messages")
    bench.assert_called_once_with({"a": "own", "b": ("b", "given", classes)})
    environment, process = master.return_value.environment, master.return_value.pid
    runner.assert_called_once_with(
        bench.return_value, known, environment, False, 160.0, process, classes
    )
    assert [call[0][0] for call in runner.return_value.run.call_args_list] == [BY_NAME["ramp"]]
    assert session.notes == ["found", "own", "followed"]
    master.return_value.close.assert_called_once_with()


@pytest.mark.parametrize(
    "place, error, says",
    [
        ("read_messages", MessageTypeError("no type"), "no type"),
        ("_run", test_bench.PublisherConflict("/a publishes set_point"), "/a publishes set_point"),
    ],
)
def test_session_that_cannot_judge_says_why_and_leaves_no_master(
    place: str, error: Exception, says: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    master = mock.Mock()
    master.return_value.folder = "/scratch"
    command = ProgramCommand("x", ["x"], {}, {}, {})
    monkeypatch.setattr(session_module, "PrivateMaster", master)
    read = mock.Mock(return_value=StudentMessages(command, {}, {}))
    monkeypatch.setattr(session_module, "read_messages", read)
    for module, name in ((bench_runner, "BenchRunner"), (test_bench, "TestBench")):
        monkeypatch.setattr(module, name, mock.Mock())
    target: Any = session_module if place == "read_messages" else Session
    monkeypatch.setattr(target, place, mock.Mock(side_effect=error))
    with pytest.raises(JudgingError, match=f"^{says}$"):
        Session(command, None, {}, 60.0).judge_with_own_plant(False)
    master.return_value.close.assert_called_once_with()


def test_session_of_its_own_plant_that_exceeds_its_time_is_not_judged(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    for name in ("PrivateMaster", "read_messages"):
        monkeypatch.setattr(session_module, name, mock.MagicMock())
    session_module.PrivateMaster.return_value.folder = "/scratch"
    session_module.read_messages.return_value = StudentMessages(mock.Mock(notes=[]), {}, {})
    for module, name in ((bench_runner, "BenchRunner"), (test_bench, "TestBench")):
        monkeypatch.setattr(module, name, mock.Mock())
    runner = bench_runner.BenchRunner.return_value = mock.Mock(
        latest=0.02, most_late=0.02, notes=[]
    )
    runner.run.side_effect = [*play_names("held", "rate"), TimeLimitExceeded]
    session = Session(ProgramCommand("x", ["x"], {}, {}, {}), None, {}, 2.5)
    judgement = session.judge_with_own_plant(True)
    assert (judgement.verdict, judgement.reason) == ("not judged", "2.5 s are over in steps")
    assert bench_runner.BenchRunner.call_args[0][3] is True


def play_names(*names: str) -> List[Record]:
    return [play_one(name, pi()) for name in names]


def test_session_keeps_the_records_before_its_time_limit() -> None:
    session: Any = Session(ProgramCommand("x", ["x"], {}, {}, {}), None, {}, 60.0)
    runner = mock.Mock(latest=0.0, most_late=0.02)
    first = Record(BY_NAME["ramp"], ENDED, answers=[(0.0, 0.0)])
    runner.run.side_effect = [first, TimeLimitExceeded]
    reason = session._run(runner, [BY_NAME[name] for name in ("ramp", "sine", "load")])
    assert (reason, session.records) == ("60 s are over in sine", [first])


def test_session_names_the_program_that_cannot_be_started() -> None:
    session: Any = Session(ProgramCommand("/anna", ["x"], {}, {}, {}), None, {}, 60.0)
    runner = mock.Mock()
    runner.run.side_effect = OSError(8, "Exec format error")
    with pytest.raises(JudgingError, match="^/anna: Exec format error$"):
        session._run(runner, [BY_NAME["ramp"]])


def test_session_ends_after_a_controller_that_never_starts_and_on_a_late_machine() -> None:
    records = [Record(BY_NAME[name], NOT_CONNECTED, missing=["set_point"]) for name in BY_NAME]
    assert len(session_of(0.01, *records).records) == 1
    says = "^this machine is too busy: the judge itself was 0.500 s late$"
    with pytest.raises(BusyMachineError, match=says):
        session_of(0.5, *records)


def test_judged_controller_has_all_gains_and_the_limits_of_its_output(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    find = mock.Mock()
    for module, name in ((bench_runner, "BenchRunner"), (test_bench, "TestBench")):
        monkeypatch.setattr(module, name, mock.Mock())
    master = mock.Mock()
    monkeypatch.setattr(gains_judgement, "PrivateMaster", master)
    monkeypatch.setattr(gains_judgement, "find_controller", find)
    monkeypatch.setattr("time.monotonic", lambda: 50.0)
    gains = Gains("x", "a test", "PID", 0.5, 0.25, 0.125, 0.01)
    sets = [gains._replace(kp=kp) for kp in (0.1, 0.2, 0.5)]
    scenarios = [BY_NAME["ramp"], BY_NAME["sine"]]
    ramp, sine = play_names("ramp", "sine")
    run = bench_runner.BenchRunner.return_value.run
    run.side_effect = [ramp, sine, ramp, TimeLimitExceeded, ramp, sine]
    judged = list(judge_gains(sets, scenarios, 9.0, least=-0.5, largest=0.75))
    passed = "passed: all 4 figures of 2 scenarios"
    assert judged == list(zip(sets, [passed, "not judged: 9 s are over", passed]))
    assert [call[0][0] for call in run.call_args_list] == scenarios * 3
    environment, process = master.return_value.environment, master.return_value.pid
    bench = test_bench.TestBench.return_value
    test_bench.TestBench.assert_called_once_with()
    assert (
        bench_runner.BenchRunner.call_args_list
        == [mock.call(bench, find.return_value, environment, False, 59.0, process)] * 3
    )
    master.return_value.close.assert_called_once_with()
    [words] = find.call_args[0]
    assert words[:2] == ["pid_control", "controller.py"]
    assert dict(word[1:].split(":=") for word in words[2:]) == {
        "mode": "PID",
        "kp": "0.5",
        "ki": "0.25",
        "kd": "0.125",
        "filter_time": "0.01",
        "output_min": "-0.5",
        "output_max": "0.75",
    }
