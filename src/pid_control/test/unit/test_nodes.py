"""Callbacks of the nodes, without a master."""

from typing import Any, List
from unittest import mock

import pytest

from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.nodes import system
from pid_control.nodes.controller import Controller
from pid_control.plant.system_parameters import SystemParameters
from pid_control.recording import live_experiment
from pid_control.recording.fields import Field
from pid_control.recording.live_experiment import LiveExperiment
from pid_control.recording.samples import Samples


def test_changed_dead_time_of_the_motor_affects_the_next_input(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("time.monotonic", lambda: 0.0)
    monkeypatch.setattr(system, "adopt_course_names", mock.Mock())
    node = mock.Mock()
    before = SystemParameters()
    node.declare_parameters.return_value.values = before
    motor = system.System(node)
    motor._on_change(before.replace(system_dead_time=0.3), before)
    motor._on_input(motor_input(1.0, 0.0))
    for time in (0.1, 0.29, 0.5):
        motor._publish(time)
    sent = [call[0][0].output for call in node.create_publisher.return_value.publish.call_args_list]
    assert sent[:2] == [0.0, 0.0] and sent[2] > 1.0


def test_controller_continues_from_its_last_input_after_missing_outputs() -> None:
    node = mock.MagicMock()
    node.declare_parameters.return_value.values = ControllerParameters(kp=0.08, ki=0.5)
    publisher = node.create_publisher.return_value
    publisher.get_num_connections.return_value = 0
    controller = Controller(node)
    controller._check_silence(0.0)
    controller._on_set_point(set_point(4.0, 0.0))
    for time, speed in ((0.01, 0.0), (0.02, 1.0), (2.0, 3.0), (2.01, 3.0)):
        controller._on_output(motor_output(speed, time, ""))
    sent = [call[0] for call in publisher.publish.call_args_list]
    inputs = [message.input for message, *rest in sent if not rest]  # without the 0 at first
    assert inputs[2] == pytest.approx(inputs[1]) and inputs[3] > inputs[2]


def test_input_of_identify_has_the_time_of_the_latest_output(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    experiment: Any = LiveExperiment.__new__(LiveExperiment)
    experiment._inputs, experiment._outputs = Samples(), Samples()
    experiment._input, experiment._message = Field("/motor_input", "input"), motor_input()
    experiment._publisher = mock.Mock()
    experiment._outputs.add(7.0, 3.5, 1.0)
    monkeypatch.setattr("rospy.get_time", lambda: 7.1)
    experiment._publish(0.5)
    experiment._publisher.publish.assert_called_once_with(motor_input(0.5, 3.5))
    assert (experiment._inputs.arrivals, experiment._inputs.values) == ([7.1], [0.5])


@pytest.mark.parametrize("arrivals, told", [([], 1), ([6.0], 1), ([8.0], 0)])
def test_identify_ends_if_the_plant_is_silent(
    arrivals: List[float], told: int, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    experiment: Any = LiveExperiment.__new__(LiveExperiment)
    experiment._has_ended, experiment._started_at = False, 5.0
    experiment._inputs, experiment._outputs = Samples(), Samples()
    experiment._output = mock.Mock(topic="/speed")
    for arrival in arrivals:
        experiment._outputs.add(arrival, None, 0.0)
    abort = mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    monkeypatch.setattr("rospy.get_time", lambda: 10.0)
    experiment._check_silence(0.0)
    assert abort.call_args_list == [mock.call("nothing on /speed for 3 s")] * told
