"""Callbacks of the nodes, without a master."""

import math
from typing import Any, List, Optional, Tuple, Type
from unittest import mock

import numpy
import pytest
from std_msgs.msg import Float64MultiArray

from nodekit.master import MISSING
from pid_control import course_names
from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.identification.record import IdentificationError
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.nodes import controller, set_point_generator, system
from pid_control.nodes.controller import Controller
from pid_control.nodes.set_point_generator import SetPointGenerator
from pid_control.plant.status import MAX_SPEED, NOT_TURNING, TURNING
from pid_control.plant.system_parameters import SystemParameters
from pid_control.recording import live_experiment
from pid_control.recording.fields import Field, FieldError
from pid_control.recording.live_experiment import DriveError, DriveSettings, LiveExperiment
from pid_control.recording.samples import Samples
from pid_control.set_point_parameters import SetPointParameters
from pid_control_msgs.msg import ControllerTerms


class Clock:
    """Machine's clock of a test, which stands still otherwise."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 100.0
        monkeypatch.setattr("time.monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch: "pytest.MonkeyPatch") -> Clock:
    return Clock(monkeypatch)


def motor_of(
    values: SystemParameters, monkeypatch: "pytest.MonkeyPatch"
) -> Tuple[system.System, mock.MagicMock]:
    monkeypatch.setattr(system, "adopt_course_names", mock.Mock())
    node = mock.MagicMock()
    node.declare_parameters.return_value.values = values
    return system.System(node), node


def speed_of(node: mock.MagicMock) -> float:
    """Return the latest output of a motor."""
    return float(node.create_publisher.return_value.publish.call_args[0][0].output)


def test_changed_dead_time_of_the_motor_affects_the_next_input(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    before = SystemParameters()
    motor, node = motor_of(before, monkeypatch)
    motor._on_change(before.replace(system_dead_time=0.3), before)
    motor._on_input(motor_input(1.0, 0.0))
    for time in (0.1, 0.29, 0.5):
        motor._publish(time)
    sent = [call[0][0].output for call in node.create_publisher.return_value.publish.call_args_list]
    assert sent[:2] == [0.0, 0.0] and sent[2] > 1.0


def test_motor_samples_its_input_and_delays_it_from_the_start_and_after_a_change(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    values = SystemParameters(
        system_param_K=2.0, system_param_T=1.0, system_sample_time=0.4, system_dead_time=0.5
    )
    motor, node = motor_of(values, monkeypatch)
    motor._on_input(motor_input(1.0, 0.0))  # it arrives at 0.5 s, and is sampled at 0.8 s
    motor._publish(1.0)
    assert speed_of(node) == pytest.approx(2.0 * -math.expm1(-0.2))
    after = dict(system_sample_time=10.0, system_dead_time=0.0, system_param_K=4.0)
    motor._on_change(values.replace(**after), values)
    motor._on_input(motor_input(0.0, 0.0))  # it is sampled at 10.8 s
    motor._publish(9.0)
    before = 2.0 * -math.expm1(-0.2)
    assert speed_of(node) == pytest.approx(4.0 + (before - 4.0) * math.exp(-8.0))


@pytest.mark.parametrize(
    "speed, status", [(13.0, MAX_SPEED), (12.0, TURNING), (0.01, NOT_TURNING), (40.0, MAX_SPEED)]
)
def test_motor_output_has_the_speed_its_time_and_the_status(
    speed: float, status: str, clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    motor, node = motor_of(SystemParameters(system_initial_cond=speed), monkeypatch)
    motor._publish(0.0)
    publish = node.create_publisher.return_value.publish
    publish.assert_called_once_with(motor_output(min(speed, 13.0), 0.0, status))
    motor._publish(0.25)
    assert publish.call_args[0][0].time == 0.25


def test_nodes_have_their_topics_and_stop_at_their_end(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    motor, node = motor_of(SystemParameters(), monkeypatch)
    system.adopt_course_names.assert_called_once_with(node, SystemParameters)
    node.declare_parameters.assert_called_once_with(SystemParameters, on_change=motor._on_change)
    node.create_publisher.assert_called_once_with("motor_output", motor_output)
    node.create_subscription.assert_called_once_with(
        "motor_input", motor_input, motor._on_input, finite=True
    )
    node.on_shutdown.assert_called_once_with(motor._end)

    node = mock.MagicMock()
    generator = SetPointGenerator(node)
    node.declare_parameters.assert_called_once_with(SetPointParameters)
    node.create_publisher.assert_called_once_with("set_point", set_point)
    node.before_deactivate.assert_called_once_with(generator._stop)
    node.on_shutdown.assert_called_once_with(generator._end)

    rig = ControllerRig(clock)
    law, node = rig.controller, rig.node
    node.declare_parameters.assert_called_once_with(ControllerParameters, on_change=law._on_change)
    assert node.create_publisher.call_args_list == [
        mock.call("motor_input", motor_input),
        mock.call("~terms", ControllerTerms),
    ]
    assert node.create_subscription.call_args_list == [
        mock.call("set_point", set_point, law._on_set_point, finite=True),
        mock.call("motor_output", motor_output, law._on_output, finite=True),
    ]
    node.before_deactivate.assert_called_once_with(law._pause)
    node.on_shutdown.assert_called_once_with(law._end)


@pytest.mark.parametrize("is_wall", [True, False])
def test_nodes_use_the_clock_of_ros(
    is_wall: bool, clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr("rospy.rostime.is_wallclock", lambda: is_wall)
    monkeypatch.setattr("rospy.get_time", lambda: 7.0)
    motor, _ = motor_of(SystemParameters(), monkeypatch)
    clocks = (motor._clock, ControllerRig(clock).controller._clock)
    assert [one() for one in clocks] == [100.0 if is_wall else 7.0] * 2


@pytest.mark.parametrize(
    "module, name, made",
    [
        (system, "system", system.System),
        (controller, "controller", Controller),
        (set_point_generator, "set_point_generator", SetPointGenerator),
    ],
)
def test_main_runs_the_node(
    module: Any, name: str, made: type, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    run = mock.Mock()
    monkeypatch.setattr(module, "run", run)
    module.main()
    run.assert_called_once_with(name, made)


def test_motor_speed_jumps_only_to_a_changed_initial_condition(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    before = SystemParameters(system_param_T=1000.0, system_initial_cond=2.0)
    motor, node = motor_of(before, monkeypatch)
    for values, speed in ((before.replace(system_param_K=5.0), 2.0), (before, 2.0)):
        motor._on_change(values.replace(system_initial_cond=speed), before)
        motor._publish(0.0)
        assert speed_of(node) == pytest.approx(2.0)
    motor._on_change(before.replace(system_initial_cond=6.0), before)
    motor._publish(0.0)
    assert speed_of(node) == pytest.approx(6.0)
    motor._publish(2000.0)
    motor._on_change(before.replace(system_param_K=5.0), before)
    motor._publish(2000.0)
    assert speed_of(node) == pytest.approx(6.0 * 0.1353, rel=1e-3)


@pytest.mark.parametrize("late, delay", [(-50.0, 0.3), (50.0, 0.4)])
def test_motor_input_acts_between_two_outputs_whatever_the_clock_does(
    late: float, delay: float, clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    values = SystemParameters(system_dead_time=0.3, system_node_rate=10.0)
    motor, node = motor_of(values, monkeypatch)
    motor._publish(1.0)
    clock.now += late
    motor._on_input(motor_input(1.0, 0.0))
    motor._publish(1.0 + delay - 0.003)
    assert speed_of(node) == 0.0
    motor._publish(1.0 + delay + 0.01)
    assert speed_of(node) > 0.0


def test_motor_ends_at_rest_at_its_latest_time(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    motor, node = motor_of(SystemParameters(), monkeypatch)
    motor._publish(0.5)
    motor._end()
    motor._publish(0.6)
    publish = node.create_publisher.return_value.publish
    assert publish.call_args_list[1:] == [mock.call(motor_output(0.0, 0.5, NOT_TURNING))]


def test_timers_follow_a_changed_rate(monkeypatch: "pytest.MonkeyPatch") -> None:
    _, node = motor_of(SystemParameters(), monkeypatch)
    rate = node.create_timer.call_args[0][0]
    node.declare_parameters.return_value.values = SystemParameters(system_node_rate=50.0)
    assert rate() == 50.0
    # On a busy machine the outputs that are due are sent late.
    assert node.create_timer.call_args[1]["catch_up"] > 0.1
    node = mock.MagicMock()
    SetPointGenerator(node)
    rate = node.create_timer.call_args[0][0]
    node.declare_parameters.return_value.values.rate = 25.0
    assert rate() == 25.0


def test_set_point_has_its_time_and_the_stop_value_once() -> None:
    node = mock.MagicMock()
    values = node.declare_parameters.return_value.values
    values.start_delay, values.duration, values.stop_value = 2.0, 0.0, -1.0
    generator = SetPointGenerator(node)
    generator._publish(0.5)
    generator._stop()
    generator._end()
    generator._publish(0.6)
    publish = node.create_publisher.return_value.publish
    assert publish.call_args_list == [mock.call(-1.0, 0.5)] * 2
    ends = SetPointGenerator(node)
    ends._publish(0.7)
    ends._end()
    assert publish.call_args_list[2:] == [mock.call(-1.0, 0.7)] * 2
    runs = SetPointGenerator(node)
    runs._source = mock.Mock()
    runs._source.sample.side_effect = lambda time, _: mock.Mock(value=10.0 * time)
    for time in (0.5, 3.0):  # half a second after its delay
        runs._publish(time)
    assert publish.call_args_list[4:] == [mock.call(-1.0, 0.5), mock.call(5.0, 3.0)]
    runs._source.sample.assert_called_once_with(0.5, values)
    values.duration = 1.5
    for time in (3.25, 4.25):  # its duration ends at 4 s
        runs._publish(time)
    runs._stop()
    runs._publish(4.5)  # activated again
    runs._stop()
    assert publish.call_args_list[6:] == [
        mock.call(7.5, 3.25),
        mock.call(-1.0, 4.25),
        mock.call(-1.0, 4.25),
        mock.call(-1.0, 4.5),
        mock.call(-1.0, 4.5),
    ]


class ControllerRig:
    """Controller without a master, its clock, and what it sends."""

    def __init__(self, clock: Clock, **values: Any) -> None:
        self.clock, self.node = clock, mock.MagicMock(resolve="/{}".format)
        self.node.declare_parameters.return_value.values = ControllerParameters(**values)
        self.publisher = self.node.create_publisher.return_value
        self.publisher.get_num_connections.return_value = 0
        self.controller = Controller(self.node)
        self.controller._check_silence(0.0)
        self.controller._on_set_point(set_point(4.0, 0.0))

    def sent(self, time: float, speed: float = 0.0) -> List[Tuple[float, float]]:
        """Send an output; return the inputs and their times that follow."""
        self.publisher.publish.reset_mock()
        self.controller._on_output(motor_output(speed, time, ""))
        return self.heard()

    def heard(self) -> List[Tuple[float, float]]:
        """Return the inputs and their times."""
        calls = [call[0] for call in self.publisher.publish.call_args_list]
        return [(one[0].input, one[0].time) if len(one) == 1 else one for one in calls]

    def change(self, **values: Any) -> None:
        """Change parameters."""
        settings = self.node.declare_parameters.return_value
        before, settings.values = settings.values, settings.values.replace(**values)
        self.controller._on_change(settings.values, before)


@pytest.fixture
def warnings(monkeypatch: "pytest.MonkeyPatch") -> List[str]:
    """Return the warnings of the log."""
    said: List[str] = []
    monkeypatch.setattr("rospy.logwarn", lambda text, *words: said.append(text % words))
    return said


@pytest.mark.parametrize("is_disabled", [False, True])
def test_controller_disabled_or_without_set_point_stops_the_motor_once(
    is_disabled: bool, clock: Clock, warnings: List[str]
) -> None:
    clock.now = 0.1  # as a simulation begins: the motor is not silent yet
    rig = ControllerRig(clock, kp=0.1, ki=1.0, enabled=not is_disabled)
    if not is_disabled:
        rig.controller = Controller(rig.node)
        rig.controller._check_silence(0.0)
    assert [rig.sent(0.01), rig.sent(0.02)] == [[(0.0, 0.01)], []]
    rig.change(enabled=True)
    rig.controller._on_set_point(set_point(4.0, 0.0))
    assert rig.sent(0.03) == [(pytest.approx(0.44), 0.03)]
    assert rig.sent(0.04) == [(pytest.approx(0.48), 0.04)]
    rig.change(enabled=False)
    assert [rig.sent(0.05), rig.sent(0.06)] == [[(0.0, 0.05)], []]
    rig.change(enabled=True)
    assert rig.sent(0.07) == [(pytest.approx(0.44), 0.07)]
    assert warnings == []


@pytest.mark.parametrize("timeout, grows", [(0.5, False), (3.0, True)])
def test_controller_continues_from_its_last_input_after_missing_outputs(
    timeout: float, grows: bool, clock: Clock, warnings: List[str]
) -> None:
    """With a timeout of 3 s none is missing."""
    rig = ControllerRig(clock, kp=0.08, ki=0.01, timeout=timeout)
    late = 1.0 if grows else 3.0
    steps = ((0.01, 0.0), (0.02, 1.0), (2.0, late), (2.01, late))
    inputs = [rig.sent(time, speed)[0][0] for time, speed in steps]
    growth = 1.98 * 0.01 * 3.0 if grows else 0.0
    assert inputs[2] == pytest.approx(inputs[1] + growth) and inputs[3] > inputs[2]
    said = ["/motor_output: no sample for more than 0.5 s before 2 s"]
    assert warnings == ([] if grows else said)


def test_controller_continues_from_its_last_input_after_a_restart_of_the_motor(
    clock: Clock, warnings: List[str]
) -> None:
    rig = ControllerRig(clock, kp=0.08, ki=1.0)
    for time in (5.0, 5.01, 5.02):
        [(before, _)] = rig.sent(time, 1.0)
    [(after, stamp)] = rig.sent(0.0, 0.0)
    assert after == pytest.approx(before) and stamp == 0.0 and rig.sent(0.01)[0][0] > after
    assert warnings == ["/motor_output: the motor was restarted"]


def test_controller_terms_are_those_of_their_input(clock: Clock) -> None:
    gains = dict(kp=0.1, ki=0.2, kd=0.01, filter_time=0.0, feed_forward=0.02)
    rig = ControllerRig(clock, mode="PID", output_max=0.2, **gains)
    rig.publisher.get_num_connections.return_value = 1
    for time, speed in ((0.25, 1.0), (0.35, 2.0)):
        rig.publisher.publish.reset_mock()
        rig.controller._on_output(motor_output(speed, time, ""))
    answer, terms = (call[0][0] for call in rig.publisher.publish.call_args_list)
    assert answer == motor_input(0.2, 0.35)
    assert {name: getattr(terms, name) for name in terms.__slots__} == pytest.approx(
        {
            "time": 0.35,
            "error": 2.0,
            "proportional": 0.2,
            "integral": 0.04,
            "derivative": -0.1,
            "feed_forward": 0.08,
            "unlimited": 0.22,
            "output": 0.2,
        }
    )


def test_controller_first_input_does_not_continue_a_manual_output(clock: Clock) -> None:
    clock.now = 0.1  # as a simulation begins: the motor is not silent yet
    rig = ControllerRig(clock, mode="manual", manual_output=0.7, kp=0.1)
    before = rig.node.declare_parameters.return_value.values
    rig.node.declare_parameters.return_value.values = after = before.replace(mode="PI")
    rig.controller._on_change(after, before)
    assert rig.sent(0.01) == [(pytest.approx(0.4), 0.01)]


def test_controller_silent_motor_gets_0_once_and_then_a_first_input(
    clock: Clock, warnings: List[str]
) -> None:
    rig = ControllerRig(clock, kp=0.1, ki=1.0, timeout=0.5, command_timeout=0.0)
    rig.sent(0.01)
    rig.publisher.publish.reset_mock()
    clock.now += 0.4
    rig.controller._check_silence(0.0)
    assert rig.heard() == []
    for _ in range(2):
        clock.now += 0.6
        rig.controller._on_set_point(set_point(4.0, 0.0))
        rig.controller._check_silence(0.0)
    assert rig.heard() == [(0.0, 0.01)]
    assert warnings == ["/motor_output: nothing for 0.5 s: the input is 0"]
    # Its stamps do not say for how long.
    assert rig.sent(0.3) == [(pytest.approx(0.4), 0.3)]
    rig.sent(0.31, 4.0)  # the input is 0 anyway
    clock.now += 0.6
    rig.controller._check_silence(0.0)
    assert rig.heard()[1:] == [(0.0, 0.31)] and len(warnings) == 1


def test_nodes_drop_values_that_are_not_finite_and_an_inactive_one_sends_nothing(
    clock: Clock, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    rig = ControllerRig(clock)
    _, motor = motor_of(SystemParameters(), monkeypatch)
    subscriptions = [one.create_subscription.call_args_list for one in (rig.node, motor)]
    assert [[call[0][0] for call in calls] for calls in subscriptions] == [
        ["set_point", "motor_output"],
        ["motor_input"],
    ]
    assert all(call[1] == {"finite": True} for calls in subscriptions for call in calls)
    rig.controller = Controller(rig.node)  # a managed one has no timer before its activation
    rig.controller._on_set_point(set_point(4.0, 0.0))
    assert rig.sent(0.01) == []


def test_controller_notices_a_silent_motor_soon_after_the_timeout(clock: Clock) -> None:
    rate, check = ControllerRig(clock).node.create_timer.call_args[0]
    assert check.__name__ == "_check_silence" and 1.0 / rate <= 0.05


def test_controller_set_point_and_motor_silent_stops_by_the_shorter_timeout(
    clock: Clock, warnings: List[str]
) -> None:
    rig = ControllerRig(clock, timeout=20.0, command_timeout=1.0)
    clock.now += 0.5
    rig.controller._on_set_point(set_point(4.0, 0.0))
    rig.sent(0.01)
    rig.publisher.publish.reset_mock()
    for seconds, heard in ((0.9, []), (0.2, [(0.0, 0.01)]), (5.0, [(0.0, 0.01)])):
        clock.now += seconds
        rig.controller._check_silence(0.0)
        assert rig.heard() == heard
    assert rig.sent(0.02) == []
    assert warnings == ["/set_point: nothing for 1 s: the input is 0"]
    # One that is stopped already forgets the set point silently.
    rig.controller._on_set_point(set_point(4.0, 0.0))
    clock.now += 2.0
    rig.controller._check_silence(0.0)
    rig.controller._check_silence(0.0)
    assert len(warnings) == 1 and rig.sent(0.03) == []


def test_controller_set_point_without_timeout_holds_for_ever(clock: Clock) -> None:
    rig = ControllerRig(clock, timeout=60.0, command_timeout=0.0)
    rig.sent(0.01)
    clock.now += 50.0
    rig.controller._check_silence(0.0)
    assert len(rig.sent(0.02)) == 1


def test_controller_activated_again_begins_with_a_first_input(clock: Clock) -> None:
    rig = ControllerRig(clock, kp=0.1, ki=1.0)
    rig.sent(0.01)
    rig.controller._pause()
    assert rig.sent(0.2) == []
    rig.controller._check_silence(0.0)
    assert rig.sent(0.3) == [(pytest.approx(0.4), 0.3)]


def test_controller_sends_nothing_after_its_end(clock: Clock) -> None:
    rig = ControllerRig(clock)
    rig.sent(0.01)
    rig.controller._end()
    assert rig.heard()[1:] == [(0.0, 0.01)]
    rig.controller._check_silence(0.0)
    assert rig.sent(0.02) == []


def test_controller_warns_of_late_outputs_now_and_then(clock: Clock, warnings: List[str]) -> None:
    rig = ControllerRig(clock)
    assert rig.sent(0.01)
    assert [rig.sent(0.01) for _ in range(3)] == [[]] * 3
    assert warnings == ["/motor_output: sample dropped: late or repeated (0.01 s)"]
    for seconds, warned in ((5.0, 1), (6.0, 2)):
        clock.now += seconds
        assert rig.sent(0.01) == [] and len(warnings) == warned


def test_course_names_equal_to_the_private_ones_are_no_warning(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    """As at the second start on a master."""
    held = {"/m/system_param_K": 5.0, "/system_param_K": 5.0}
    master = mock.MagicMock()
    master.return_value.__enter__.return_value.read = lambda keys: mock.Mock(
        values={key: held.get(key, MISSING) for key in keys}
    )
    monkeypatch.setattr(course_names, "MasterClient", master)
    warn = mock.Mock()
    monkeypatch.setattr("rospy.logwarn", warn)
    node = mock.Mock(resolve=lambda name: "/" + name)
    node.name = "/m"
    for value in (5.0, 6.0):
        held["/system_param_K"] = value
        course_names.adopt_course_names(node, SystemParameters)
    master.assert_called_with("/m")
    assert [call[0][0] % call[0][1:] for call in warn.call_args_list] == [
        "/system_param_K: 6.0 is ignored, because /m/system_param_K: 5.0 is set; to use it at "
        "the next start: rosparam delete /m/system_param_K"
    ]


def test_course_names_are_copied_to_private_parameters_that_are_unset(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    held = {"/m/system_param_T": 0.5, "/system_param_T": 0.1, "/system_param_K": 5.0}
    held["/system_max_speed"] = 9.0
    master = mock.MagicMock()
    known = master.return_value.__enter__.return_value
    known.read = lambda keys: mock.Mock(values={key: held.get(key, MISSING) for key in keys})
    monkeypatch.setattr(course_names, "MasterClient", master)
    monkeypatch.setattr("rospy.logwarn", mock.Mock())
    told = mock.Mock()
    monkeypatch.setattr("rospy.loginfo", told)
    node = mock.Mock(resolve=lambda name: "/" + name)
    node.name = "/m"
    course_names.adopt_course_names(node, SystemParameters)
    known.write.assert_called_once_with({"/m/system_param_K": 5.0, "/m/system_max_speed": 9.0})
    held.clear()
    course_names.adopt_course_names(node, SystemParameters)
    assert [call[0][0] % call[0][1:] for call in told.call_args_list] == [
        "/m: parameters copied from the course's names: "
        "/system_param_K: 5.0, /system_max_speed: 9.0"
    ]


def experiment_on(
    monkeypatch: "pytest.MonkeyPatch",
    output: str = "motor_output/output",
    *others: str,
    given: str = "motor_input/input",
    now: float = 0.0,
) -> Tuple[Any, mock.MagicMock]:
    """Return an experiment of /identify, of which the master knows an earlier one, and its node.

    :param others: other nodes that drive the motor
    """
    master = mock.MagicMock()
    known = master.return_value.__enter__.return_value
    known.system_state.return_value.publishers = [("/motor_input", ["/identify", *others])]
    known.topic_types.return_value = {
        "/motor_input": "pid_control/motor_input",
        "/motor_output": "pid_control/motor_output",
        "/array": "std_msgs/Float64MultiArray",
        "/foreign": "no_such_package/Type",
    }
    monkeypatch.setattr(live_experiment, "MasterClient", master)
    monkeypatch.setattr("rospy.get_time", lambda: now)
    node = mock.MagicMock(resolve=lambda name: "/" + name)
    node.name = "/identify"
    drive = DriveSettings(given, output, -0.25, 1.0, 10.0)
    return LiveExperiment(node, drive, mock.Mock()), node


def test_identify_begins_with_the_first_output_and_ends_with_an_input_of_0(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    experiment, node = experiment_on(monkeypatch)
    publish = node.create_publisher.return_value.publish
    experiment._on_output(motor_output(1.0, 0.5, ""))  # before the first clock
    experiment._send(0.0)
    assert not publish.called
    monkeypatch.setattr("rospy.get_time", lambda: 2.0)
    experiment._on_output(motor_output(1.0, 0.5, ""))
    sent: List[float] = []
    publish.side_effect = lambda message: sent.append(message.input)
    abort = mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    for time in range(110):
        experiment._send(0.1 * time)
    assert (min(sent), max(sent)) == (-0.25, 1.0) and len(sent) > 90 and sent[-1] == 0.0
    experiment._end()
    abort.assert_called_once_with("record not usable: it has 1 outputs; 20 are the least")
    node.create_publisher.assert_called_once_with("/motor_input", motor_input)
    node.create_subscription.assert_called_once_with(
        "/motor_output", motor_output, experiment._on_output
    )
    # A paused clock is a silent plant too.
    assert node.create_timer.call_args_list == [
        mock.call(200.0, experiment._send),
        mock.call(10.0, experiment._check_silence, steady=True),
    ]
    node.on_shutdown.assert_called_once_with(experiment._end)


@pytest.mark.parametrize(
    "error, why",
    [
        (None, ""),
        (IdentificationError("too short"), "record not usable: too short"),
        (PermissionError(13, "Permission denied", "/x.yaml"), "/x.yaml: Permission denied"),
    ],
)
def test_identify_ends_with_a_record_of_all_inputs_and_outputs(
    error: Optional[Exception], why: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    experiment, _ = experiment_on(monkeypatch)
    experiment._on_record.side_effect = error
    abort, shutdown = mock.Mock(), mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    monkeypatch.setattr("rospy.signal_shutdown", shutdown)
    for number in range(110):
        late = 0.02 * (number % 2)  # the stamps say when it was measured
        monkeypatch.setattr("rospy.get_time", lambda: 50.0 + 0.1 * number + late)
        experiment._on_output(motor_output(0.5 * number, 0.1 * number, ""))
        experiment._send(0.1 * number)
    [(record,)] = [call[0] for call in experiment._on_record.call_args_list]
    assert record.duration == pytest.approx(10.0, abs=0.3) and record.left_out == 0
    assert record.outputs[:3].tolist() == [0.0, 0.5, 1.0]
    assert numpy.diff(record.times) == pytest.approx(0.1)
    assert (record.inputs.min(), record.inputs.max()) == (-0.25, 1.0)
    experiment._end()  # the shutdown's
    assert abort.call_args_list == ([mock.call(why)] if why else [])
    assert shutdown.call_args_list == ([] if why else [mock.call("the record is complete")])


@pytest.mark.parametrize(
    "output, others, error, why",
    [
        (
            "motor_output/output",
            ["/a", "/b"],
            DriveError,
            "/motor_input: driven by another node (/a, /b); stop it first",
        ),
        (
            "foreign/x",
            [],
            DriveError,
            "/foreign: message type not installed (no_such_package/Type)",
        ),
        (
            "motor_output/speed",
            [],
            FieldError,
            "/motor_output/speed: unknown field 'speed'; it has: output, time, status",
        ),
    ],
)
def test_identify_names_what_it_cannot_drive_or_hear(
    output: str,
    others: List[str],
    error: Type[Exception],
    why: str,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    with pytest.raises(error) as raised:
        experiment_on(monkeypatch, output, *others)
    assert str(raised.value) == why


def test_identify_input_that_is_missing_is_named_before_anything_is_sent(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    with pytest.raises(
        FieldError, match="^/motor_input/u: unknown field 'u'; it has: input, time$"
    ):
        experiment_on(monkeypatch, given="motor_input/u")


def test_identify_waits_3_s_for_the_first_output(monkeypatch: "pytest.MonkeyPatch") -> None:
    experiment, node = experiment_on(monkeypatch, now=50.0)
    abort = mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    for now, aborts in ((52.9, 0), (53.1, 1)):
        monkeypatch.setattr("rospy.get_time", lambda: now)
        experiment._check_silence(0.0)
        assert abort.call_count == aborts
    assert not node.create_publisher.return_value.publish.called


def test_identify_element_of_an_array_is_an_output(monkeypatch: "pytest.MonkeyPatch") -> None:
    experiment, node = experiment_on(monkeypatch, "array/data[1]")
    monkeypatch.setattr("rospy.get_time", lambda: 2.0)
    experiment._on_output(Float64MultiArray(data=[1.0, 2.5]))
    assert experiment._outputs.values == [2.5]
    abort = mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    experiment._on_output(Float64MultiArray(data=[1.0]))
    abort.assert_called_once_with("/array/data[1]: 'data[1]' is not an element of an array")
    assert experiment._has_ended and experiment._outputs.values == [2.5]
    assert not node.create_publisher.return_value.publish.called  # as nothing was sent before


def test_identify_that_is_ended_early_stops_the_plant(monkeypatch: "pytest.MonkeyPatch") -> None:
    experiment, node = experiment_on(monkeypatch)
    abort = mock.Mock()
    monkeypatch.setattr(live_experiment, "abort", abort)
    monkeypatch.setattr("rospy.get_time", lambda: 2.0)
    experiment._on_output(motor_output(1.0, 0.5, ""))
    for time in (0.0, 2.0):
        experiment._send(time)
    publish = node.create_publisher.return_value.publish
    count = publish.call_count
    for _ in range(2):
        experiment._end()
        experiment._send(4.0)
        experiment._check_silence(0.0)
    assert publish.call_count == count + 1 and publish.call_args[0][0].input == 0.0
    abort.assert_called_once_with("ended before the record was complete")


def test_input_of_identify_has_the_time_of_the_latest_output(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    experiment: Any = LiveExperiment.__new__(LiveExperiment)
    experiment._inputs, experiment._outputs = Samples(), Samples()
    experiment._input, experiment._message = Field("/motor_input", "input"), motor_input()
    experiment._publisher = mock.Mock()
    experiment._outputs.add(6.9, 3.4, 1.0)
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
