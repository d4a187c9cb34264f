"""Runners of submissions, without their processes."""

import threading
from typing import Any, List
from unittest import mock

import pytest

from pid_control.judging.plant_log import PlantLog
from pid_control.judging.scenarios import BY_NAME
from pid_control.msg import motor_input, motor_output
from pid_control.programs.program_command import ProgramCommand
from pid_control.runner import bench_runner, clock, gains_judgement, test_bench
from pid_control.runner.bench_runner import BenchRunner
from pid_control.runner.gains_judgement import judge_gains
from pid_control.runner.real_plant import RealPlant
from pid_control.signal_judging.evidence import FailedTrial
from pid_control.signal_runner.signal_bench import SignalBench
from pid_control.signal_runner.signal_session import SignalSession
from pid_control.tuning.rules import Gains


def test_answers_in_the_first_half_of_a_pause_count_as_late(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(clock, "_STANDSTILL_S", 0.02)
    watch = mock.Mock()
    watch.is_idle.return_value = True
    simulated = clock.SimulatedClock(watch)
    simulated.start()
    pause = simulated.pause(0.0, mock.Mock(side_effect=[9, 4]))
    assert pause.answers == 4
    assert simulated.pause(0.0, mock.Mock(return_value=0)).length >= 0.04  # twice as long


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
        runner.run(BY_NAME["ramp"]._replace(duration=0.01))
    assert runner.latest == 0.5 and next(late, None) is None


def test_log_of_a_real_plant_has_each_output_with_the_latest_input() -> None:
    plant: Any = RealPlant.__new__(RealPlant)
    plant._lock, plant._log, plant._input = threading.Lock(), PlantLog([], []), 0.0
    plant._on_input(motor_input(0.25, 0.0))
    plant._on_output(motor_output(2.0, 0.0, ""))
    log = plant.pop_log()
    assert [output[1:] for output in log.outputs] == [(2.0, 0.25)]
    assert [value for _, value in log.inputs] == [0.25]
    assert plant.pop_log() == ([], [])


def test_shutdown_beside_a_real_plant_ends_the_controller_before_the_last_input() -> None:
    calls: List[str] = []
    plant: Any = RealPlant.__new__(RealPlant)
    plant.on_shutdown(lambda: calls.append("controller"))
    plant.stop = lambda: calls.append("0")
    plant._shut_down()
    assert calls == ["controller", "0"]


def test_signal_bench_subscribes_only_to_the_latest_topics() -> None:
    bench: Any = SignalBench.__new__(SignalBench)
    bench._lock, bench._subscriptions = threading.Lock(), {}
    bench._node, bench._scope = mock.Mock(), mock.Mock()
    before = bench._scope
    bench.listen({})
    before.close.assert_called_once_with()


def test_repeated_record_forgets_failures_of_the_first(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    session = SignalSession(mock.Mock(), [], False, 60.0, {}, mock.Mock(), mock.Mock())
    session.evidence.broken["restart"] = FailedTrial("crash", "/generator")
    monkeypatch.setattr(session, "_trial", mock.MagicMock())
    monkeypatch.setattr(session, "_record_baseline", mock.Mock())
    session._repeat_baseline(mock.Mock())
    assert session.evidence.broken == {}


def test_judged_controller_has_all_gains_and_the_limits_of_its_output(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    find = mock.Mock()
    for module, name in ((bench_runner, "BenchRunner"), (test_bench, "TestBench")):
        monkeypatch.setattr(module, name, mock.Mock())
    monkeypatch.setattr(gains_judgement, "PrivateMaster", mock.Mock())
    monkeypatch.setattr(gains_judgement, "find_controller", find)
    gains = Gains("x", "a test", "PID", 0.5, 0.25, 0.125, 0.01)
    list(judge_gains([gains], [], least=-0.5, largest=0.75))
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
