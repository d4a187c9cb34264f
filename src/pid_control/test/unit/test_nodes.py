"""Callbacks of the nodes, without a master."""

from typing import Any, List
from unittest import mock

import pytest

from pid_control.msg import motor_input
from pid_control.nodes import system
from pid_control.plant.system_parameters import SystemParameters
from pid_control.recording import live_experiment
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
