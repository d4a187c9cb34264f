"""Tests of the node and the runner beside a real plant, without a master."""

import re
from contextlib import nullcontext
from typing import Any, List, Optional
from unittest import mock

import pytest

from nodekit.master import MasterUnreachable
from pid_control.judging.plant_log import PlantLog
from pid_control.judging.record import ENDED, NOT_CONNECTED, Record, Row
from pid_control.judging.scenarios import BY_NAME, MOTOR
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.programs.program_command import ProgramCommand
from pid_control.runner import real_plant, real_plant_runner
from pid_control.runner.judging_errors import JudgingError, TimeLimitExceeded
from pid_control.runner.real_plant import PlantError, RealPlant
from pid_control.runner.real_plant_runner import RealPlantRunner
from pid_control.runner.session import Session


def test_node_of_a_real_plant_logs_each_output_with_the_latest_input(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    now = iter([100.0, 100.25, 100.5, 100.75])
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    monkeypatch.setattr(real_plant, "_check_graph", mock.Mock())
    node = mock.Mock()
    node.resolve.return_value = "/lab/y"
    monkeypatch.setattr(real_plant, "init_node", lambda name: {"judge": node}[name])
    plant: Any = RealPlant()
    real_plant._check_graph.assert_called_once_with()
    assert node.mock_calls == [
        mock.call.resolve("motor_output"),
        mock.call.create_publisher("set_point", set_point),
        mock.call.create_publisher("motor_input", motor_input),
        mock.call.create_subscription("motor_input", motor_input, plant._on_input),
        mock.call.create_subscription("motor_output", motor_output, plant._on_output, finite=True),
        mock.call.on_shutdown(plant._shut_down),
        mock.call.start(),
    ]
    assert plant.pop_log() == ([], [])
    plant._on_output(motor_output(1.0, 0.0, ""))
    plant._on_input(motor_input(0.25, 0.0))
    plant._on_output(motor_output(2.0, 0.0, ""))
    assert plant.pop_log() == ([(100.25, 1.0, 0.0), (100.75, 2.0, 0.25)], [(100.5, 0.25)])
    assert plant.pop_log() == ([], [])
    assert (plant._heard_at, plant._speed, plant._topic) == (100.75, 2.0, "/lab/y")


def test_shutdown_beside_a_real_plant_ends_the_controller_before_the_last_input(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    calls: List[Any] = []
    monkeypatch.setattr("time.sleep", calls.append)
    plant: Any = RealPlant.__new__(RealPlant)
    plant.on_shutdown(lambda: calls.append("controller"))
    plant.stop = lambda: calls.append("0")
    plant._shut_down()
    assert calls == ["controller", 0.01, "0"]  # its last message may still arrive
    for call in (plant.check_node, plant.wait_until_it_stands, lambda: plant.send_set_point(1.0)):
        with pytest.raises(PlantError, match="^the node was shut down$"):
            call()


def test_real_plant_is_stopped_by_a_set_point_and_an_input_of_0(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    slept = []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += 1.0

    monkeypatch.setattr("time.sleep", sleep)
    plant: Any = RealPlant.__new__(RealPlant)
    plant._set_points, plant._drive = mock.Mock(), mock.Mock()
    plant._began, plant._heard_at, plant._is_shut_down, plant._topic = 90.0, 99.5, False, "/y"
    plant._speed, plant._sent_at = -0.5, 99.9  # encoders are coarse
    plant.wait_until_it_stands()
    plant._set_points.publish.assert_called_once_with(set_point(0.0, 10.0))
    plant._drive.publish.assert_called_once_with(motor_input(0.0, 0.0))
    plant.send_set_point(3.0)
    plant._set_points.publish.assert_called_with(set_point(3.0, 10.0))
    plant._speed, plant._heard_at = -5.25, 200.0
    with pytest.raises(PlantError, match="^the input is 0, and the plant turns at -5.25 rad/s$"):
        plant.wait_until_it_stands()
    assert slept == [0.01] * 6 and plant._drive.publish.call_count == 1 + 7
    now[0], plant._speed = 300.0, 0.0
    with pytest.raises(PlantError, match="^the plant is silent: nothing on /y$"):
        plant.wait_until_it_stands()
    assert now[0] == 306.0
    plant._heard_at = now[0] - 0.7
    plant.send_set_point(1.0)
    plant._heard_at = now[0] - 0.9
    with pytest.raises(PlantError, match="^the plant is silent: nothing on /y for 0.8 s$"):
        plant.send_set_point(1.0)
    now[0] += 0.5  # the judge was held up, and has not yet received the outputs of that time
    plant.send_set_point(1.0)
    for _ in range(2):
        now[0] += 0.4
        plant.send_set_point(1.0)
    now[0] += 0.1
    with pytest.raises(PlantError, match="^the plant is silent: nothing on /y for 0.8 s$"):
        plant.send_set_point(1.0)


def test_real_plant_that_says_nothing_is_not_at_rest(monkeypatch: "pytest.MonkeyPatch") -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("time.sleep", lambda _: now.append(now.pop() + 0.5))
    monkeypatch.setattr(real_plant, "_check_graph", mock.Mock())
    init_node = mock.MagicMock()
    monkeypatch.setattr(real_plant, "init_node", init_node)
    plant = RealPlant()
    with pytest.raises(PlantError, match="the plant is silent"):
        plant.wait_until_it_stands()


@pytest.mark.parametrize(
    "simulates, publishers, says",
    [
        (None, [("/motor_output", ["/m"])], ""),
        (
            True,
            [("/motor_output", ["/m"])],
            "/use_sim_time is true: a real plant uses the machine's clock",
        ),
        (None, [], "no plant found: ~/motor_output has no publisher"),
        (
            None,
            [("/motor_output", ["/m"]), ("/set_point", ["/s"])],
            "~/set_point: published by another node (/s); stop it first",
        ),
        (
            None,
            [("/motor_output", ["/m"]), ("/motor_input", ["/c", "/d"])],
            "~/motor_input: published by another node (/c and /d); stop it first",
        ),
    ],
)
def test_graph_of_a_real_plant_has_a_motor_and_nothing_else(
    simulates: Optional[bool],
    publishers: List[Any],
    says: str,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    master = mock.MagicMock()
    known = master.return_value.__enter__.return_value
    known.read.return_value.values = {"/use_sim_time": simulates or mock.Mock()}
    known.topic_types.return_value = {}
    known.system_state.return_value = mock.Mock(
        publishers=publishers, subscribers=[("/motor_input", ["/m"])]
    )
    monkeypatch.setattr(real_plant, "MasterClient", master)
    monkeypatch.setattr("rospy.resolve_name", lambda name: f"{namespace}/{name}")
    for namespace in ("", "/lab"):
        state = known.system_state.return_value
        state.publishers = [(f"{namespace}{topic}", nodes) for topic, nodes in publishers]
        state.subscribers = [(f"{namespace}/motor_input", ["/m"])]
        expected = re.escape(says.replace("~", namespace))
        with pytest.raises(PlantError, match=f"^{expected}$") if says else nullcontext():
            real_plant._check_graph()
    assert master.call_args_list == [mock.call("/judge")] * 2
    known.read.assert_called_with(["/use_sim_time"])


@pytest.mark.parametrize(
    "types, subscribers, says",
    [
        ({"/motor_input": "*", "/other": "x/Y"}, [("/motor_input", ["/m"])], ""),
        (
            {"/set_point": "std_msgs/Float32"},
            [("/motor_input", ["/m"])],
            "/set_point has std_msgs/Float32, not pid_control/set_point",
        ),
        ({}, [("/set_point", ["/m"])], "no plant found: /motor_input has no subscriber"),
    ],
)
def test_graph_of_a_real_plant_has_a_motor_with_the_types_of_the_course(
    types: Any, subscribers: List[Any], says: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    master = mock.MagicMock()
    known = master.return_value.__enter__.return_value
    known.topic_types.return_value = types
    known.system_state.return_value = mock.Mock(
        publishers=[("/motor_output", ["/m"])], subscribers=subscribers
    )
    monkeypatch.setattr(real_plant, "MasterClient", master)
    with pytest.raises(PlantError, match=says) if says else nullcontext():
        real_plant._check_graph()
    master.side_effect = MasterUnreachable("it does not answer")
    says = "^a real plant needs your own master: it does not answer$"
    with pytest.raises(PlantError, match=says):
        real_plant._check_graph()


def test_real_plant_counts_connections_and_stops_before_its_node_ends(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    calls: List[str] = []
    plant: Any = RealPlant.__new__(RealPlant)
    plant._set_points, plant._answers = mock.Mock(), mock.Mock()
    plant._set_points.get_num_connections.return_value = 2
    plant._answers.get_num_connections.return_value = 3
    assert plant.connections() == {"set_point": 2, "motor_input": 3}
    plant.stop = lambda: calls.append("0")
    monkeypatch.setattr("rospy.signal_shutdown", calls.append)
    plant.close()
    assert calls == ["0", "the judgement is complete"]


@pytest.mark.parametrize("status, failure", [(None, NOT_CONNECTED), (1, ENDED)])
def test_controller_that_does_not_connect_beside_a_real_plant_ends(
    status: Optional[int], failure: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    plant, process = mock.Mock(), mock.Mock(status=status)
    process.last_words.return_value = "waiting"
    plant.connections.side_effect = [
        {"set_point": 1, "motor_input": 1},
        *[{"set_point": 2, "motor_input": 1}] * 9,
    ]
    monkeypatch.setattr(real_plant_runner, "ProgramProcess", lambda *_: process)
    monkeypatch.setattr(real_plant_runner, "_CONNECT_S", 0.0)
    command = ProgramCommand("x", ["x"], {}, {}, {})
    runner = RealPlantRunner(plant, command, MOTOR.max_output, float("inf"))
    record = runner.run(BY_NAME["steps"])
    assert record == Record(BY_NAME["steps"], failure, "waiting", ["motor_input"])
    process.end.assert_called_once_with()
    assert plant.stop.called and not plant.check_alone.called
    late = RealPlantRunner(plant, command, MOTOR.max_output, 0.0)
    with pytest.raises(TimeLimitExceeded):
        late.run(BY_NAME["steps"])
    assert process.end.call_count == 2


@pytest.mark.parametrize("topic", ["/y", "/r"])
def test_controller_with_a_plant_or_set_point_of_its_own_is_refused(
    topic: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    master = mock.MagicMock()
    state = master.return_value.__enter__.return_value.system_state
    state.return_value.publishers = [("/y", ["/a"]), ("/r", ["/judge"]), ("/u", ["/b", "/c"])]
    monkeypatch.setattr(real_plant, "MasterClient", master)
    plant: Any = RealPlant.__new__(RealPlant)
    plant._topic, plant._set_points = "/y", mock.Mock(resolved_name="/r")
    monkeypatch.setattr("rospy.get_name", lambda: "/judge")
    plant.check_alone()
    master.assert_called_once_with("/judge")
    state.return_value.publishers = [(topic, ["/a", "/b"])]
    with pytest.raises(PlantError, match=f"^/a and /b publish {topic}; stop all but one$"):
        plant.check_alone()
    master.side_effect = MasterUnreachable("it does not answer")
    with pytest.raises(PlantError, match="^it does not answer$"):
        plant.check_alone()


def test_controller_beside_a_real_plant_ends_between_two_stops(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    calls: List[str] = []
    plant, process = mock.Mock(), mock.Mock(status=None, writes_without_end=False)
    plant.stop = lambda: calls.append("stop")
    process.interrupt = lambda: calls.append("interrupt")
    process.end = lambda: calls.append("end")
    process.watch.busy.side_effect = [5.0, 5.75, 9.0, 9.5]
    plant.connections.side_effect = [{"motor_input": 1}, {"motor_input": 1}, {"motor_input": 2}]
    late = mock.Mock(latest=0.5)
    start = mock.Mock(return_value=process)
    monkeypatch.setattr("time.monotonic", lambda: 99.5)
    monkeypatch.setattr(real_plant_runner, "WallClock", lambda: late)
    monkeypatch.setattr(real_plant_runner, "ProgramProcess", start)
    monkeypatch.setattr(real_plant_runner, "get_master_uri", lambda: "http://master")
    monkeypatch.setattr("time.sleep", mock.Mock())
    set_param = mock.Mock()
    monkeypatch.setattr("rospy.set_param", set_param)
    log = PlantLog([(100.1, 2.0, 0.5), (100.2, 4.0, 0.75)], [(99.5, 0.5), (100.15, 0.75)])
    plant.pop_log.side_effect = lambda: calls.append("log") or next(logs)
    command = ProgramCommand("x", ["x"], {}, {"/a": 1}, {"/motor/b": 2})
    runner = RealPlantRunner(plant, command, 2.0 * MOTOR.max_output, float("inf"))
    set_param.assert_called_once_with("/a", 1)  # not the plant's own
    logs = iter([PlantLog([(100.1, 9.0, 9.0)], [(100.1, 9.0)]), log, log, log])
    scenario = BY_NAME["steps"]._replace(duration=0.3)
    record = runner.run(scenario)
    assert record == Record(
        scenario,
        rows=[
            Row(pytest.approx(0.1), 0.0, 1.0, 0.5),
            Row(pytest.approx(0.2), 5.0, 2.0, 0.75),
        ],
        answers=[(-0.5, 0.5), (pytest.approx(0.15), 0.75)],
        busy=0.75,
    )
    start.assert_called_once_with(command, {"ROS_MASTER_URI": "http://master"})
    waits = [call[0][0] for call in late.wait.call_args_list]
    assert waits == pytest.approx([0.01 * step for step in range(1, 81)])
    late.start.assert_called_once_with()
    assert plant.connections.call_count == 3  # until there is one more than before
    # A log before the scenario is dropped.
    assert calls == ["log", "log", "stop", "interrupt", "end", "stop"]
    sent = [call[0][0] for call in plant.send_set_point.call_args_list]
    assert sent == [0.0] * 72 + [10.0] * 10  # twice as fast as the course's motor
    assert plant.check_node.called
    late.latest = 0.1
    plant.connections.side_effect = [{"motor_input": 1}, {"motor_input": 2}]
    runner.run(BY_NAME["steps"]._replace(duration=0.3))
    assert (runner.latest, runner.most_late) == (0.5, 0.1)
    # One that the machine killed is no failure; nor is one that a shutdown of the node ended.
    process.status, process.watch.busy.side_effect = -9, None
    plant.pop_log.side_effect = None
    for error, shown in ((None, JudgingError), (PlantError("the node was shut down"), PlantError)):
        calls.clear()
        plant.connections.side_effect = [{"motor_input": 1}, {"motor_input": 2}]
        plant.check_node.side_effect = error
        with pytest.raises(shown, match="killed" if error is None else "shut down"):
            runner.run(scenario)
        assert calls == ["stop", "interrupt", "end", "stop"]


def test_session_with_a_real_plant_names_the_scenarios_left_out(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(real_plant, "RealPlant", mock.Mock())
    runner: Any = mock.Mock()
    runner.return_value = mock.Mock(latest=0.0, most_late=0.1)
    runner.return_value.run.side_effect = lambda scenario: Record(scenario, ENDED, answers=[(1, 1)])
    monkeypatch.setattr(real_plant_runner, "RealPlantRunner", runner)
    command = ProgramCommand("x", ["x"], {}, {"/use_sim_time": False}, {})
    monkeypatch.setattr("time.monotonic", lambda: 100.0)
    possible = ["steps", "ramp", "sine", "windup"]
    for only, ran in ((None, possible), ([BY_NAME["ramp"]], ["ramp"])):
        session = Session(command, only, {}, 60.0)
        judgement = session.judge_with_real_plant(13.0)
        assert [record.scenario.name for record in session.records] == ran
        assert judgement.left_out == [name for name in BY_NAME if name not in possible]
        plant = real_plant.RealPlant.return_value
        runner.assert_called_with(plant, command, 13.0, 160.0)
    says = "held is not for a real plant: there are steps, ramp, sine, windup"
    with pytest.raises(JudgingError, match=f"^{says}$"):
        Session(command, [BY_NAME["held"]], {}, 60.0).judge_with_real_plant(13.0)
    runner.return_value.run.side_effect = PlantError("the plant is silent")
    with pytest.raises(JudgingError, match="^the plant is silent$"):
        Session(command, None, {}, 60.0).judge_with_real_plant(13.0)
    assert real_plant.RealPlant.return_value.close.call_count == 3
    runner.return_value.run.side_effect = TimeLimitExceeded
    judgement = Session(command, None, {}, 60.0).judge_with_real_plant(13.0)
    assert (judgement.verdict, judgement.reason) == ("not judged", "60 s are over in steps")
