"""Tests of launch arguments: validated by one rule, and passed to the node unchanged."""

import os
from typing import Dict, List

import pytest
from basic_comms.nodes.fleet import FleetParameters
from basic_comms.signals.signal_parameters import SignalParameters
from roslaunch import RLException

from nodekit import ParameterError

from .launching import FILES, SOURCES, command_line, defaults, load, settings, whole

TRUTH = [
    (name, argument)
    for name in FILES
    for argument, default in defaults(name).items()
    if default in ("true", "false")
]
#: Texts with special characters of YAML, a shell, roslaunch or Python.
TEXTS = [
    "a b", "/tmp/a #1.csv", "a: b", "a:b", "@a", "~b", "it's", 'say "hi"', "\\n", "- a", "[1", "{a",
    "&a", "*a", "!a", "%s", "$HOME", "$(", "`ls`", "; ls", "--port=1", "-x", "ä", "",
    "5", "007", "1.50", "1e3", "0x10", "true", "No", "null", "2020-02-29",
]  # fmt: skip
ROBOTS = ["basic_comms/launch/groups.launch", "motor_control/launch/motors.launch"]
FLEET = "basic_comms/launch/fleet.launch"
SCOPE = "topic_scope/launch/scope.launch"


#: Packages with launch files without boolean arguments.
WITHOUT_TRUTH = {"robot_interfaces_demo"}


def test_there_are_truth_values_in_every_other_package_with_launch_files() -> None:
    packages = {name.split("/")[0] for name in FILES}
    assert {name.split("/")[0] for name, _ in TRUTH} == packages - WITHOUT_TRUTH


@pytest.mark.parametrize("name, argument", TRUTH)
def test_a_truth_value_is_any_of_four_words_in_any_case(name: str, argument: str) -> None:
    yes, no = (whole(load(name, f"{argument}:={text}")) for text in ("true", "false"))
    assert yes != no
    for text in ("TRUE", "1", "yes", "On"):
        assert whole(load(name, f"{argument}:={text}")) == yes, text
    for text in ("False", "0", "No", "off"):
        assert whole(load(name, f"{argument}:={text}")) == no, text


def test_nodes_get_truth_values_and_no_numbers() -> None:
    changed = {}
    for name, argument in TRUTH:
        yes, no = (settings(load(name, f"{argument}:={text}")) for text in ("1", "0"))
        for key in {*yes} & {*no}:
            if yes[key] != no[key]:
                changed[name, argument, key] = (yes[key], no[key])
    assert changed
    assert {key: values for key, values in changed.items() if values != (True, False)} == {}


@pytest.mark.parametrize("name, argument", TRUTH)
@pytest.mark.parametrize("text", ["maybe", "2", "true false"])
def test_any_other_is_refused(name: str, argument: str, text: str) -> None:
    with pytest.raises((RLException, ValueError)) as caught:
        load(name, f"{argument}:={text}")
    said = str(caught.value)
    assert argument in said and f"'{text}'" in said
    assert "{'true': True, 'yes': True, 'on': True, '1': True, " in said
    assert "'false': False, 'no': False, 'off': False, '0': False}" in said


#: Files and their arguments that are text for a parameter of a node.
PARAMETERS: Dict[str, Dict[str, str]] = {
    "basic_comms/launch/signal_gen.launch": {
        "waveform": "/signal_generator/waveform",
        "chirp_shape": "/signal_generator/chirp_shape",
        "file": "/signal_generator/file",
        "file_mode": "/signal_generator/file_mode",
    },
    "basic_comms/launch/cw1.launch": {
        "signal_waveform": "/signal_generator/waveform",
        "signal_file": "/signal_generator/file",
        "process_method": "/process/method",
    },
    "basic_comms/launch/process.launch": {"method": "/process/method"},
    "basic_comms/launch/fleet.launch": {"prefix": "/fleet/prefix"},
    "basic_comms/launch/talker_listener.launch": {"scope": "/talker/message_scope"},
    "basic_comms/launch/features/arg.launch": {"text": "/arg_talker/Message"},
    "bot_controller_demo/launch/proportional_controller.launch": {
        "controller_type": "/proportional_controller/controller_type",
        "control_law": "/proportional_controller/control_law",
    },
    "bot_controller_demo/launch/random_controller.launch": {
        "controller_type": "/random_controller/controller_type",
    },
    "bot_controller_demo/launch/teleop_keyboard.launch": {"model": "/teleop_keyboard/model"},
    "diff_drive_sim/launch/diff_drive.launch": {
        "controller_type": "/diff_drive/controller_type",
        "frame_prefix": "/diff_drive/frame_prefix",
    },
    "diff_drive_sim/launch/fleet.launch": {"prefix": "/diff_drive_fleet/prefix"},
    "first_order_sys_sim/launch/system.launch": {"method": "/first_order_sys/method"},
    "parameters_demo/launch/demo3.launch": {
        "lidar_model": "/lidar_demo/lidar_model",
        "processing_mode": "/processing_demo/processing_mode",
    },
    "parameters_demo/launch/talker_listener_launch.launch": {
        "message_prefix": "/robot1/talker/message_prefix",
    },
}


@pytest.mark.parametrize("text", [text for text in TEXTS if text])
@pytest.mark.parametrize("name", PARAMETERS)
def test_text_reaches_the_parameter_as_typed(name: str, text: str) -> None:
    wanted = {parameter: text for parameter in PARAMETERS[name].values()}
    typed = [f"{argument}:={text}" for argument in PARAMETERS[name]]
    found = settings(load(name, *typed))
    assert {parameter: found[parameter] for parameter in wanted} == wanted


@pytest.mark.parametrize("text", [text for text in TEXTS if text])
def test_the_robot_is_expected_as_typed(text: str) -> None:
    launch = "robot_interfaces_demo/launch/robot_status_demo.launch"
    found = settings(load(launch, f"robot_name:={text}"))
    assert found["/fleet_monitor/expected"] == [found["/robot_monitor/robot_name"]] == [text]


def test_missing_file_has_no_text() -> None:
    for name in ("basic_comms/launch/signal_gen.launch", "basic_comms/launch/cw1.launch"):
        assert settings(load(name))["/signal_generator/file"] == ""


@pytest.mark.parametrize("space", ["5", "007", "True", "1.5", "7/8"])
def test_a_name_may_look_like_a_number(space: str) -> None:
    cw1 = load("basic_comms/launch/cw1.launch", "ns:=" + space, "plot:=true")
    assert {node.namespace for node in cw1.nodes} == {f"/{space}/"}
    pair = load("basic_comms/launch/talker_listener.launch", "prefix:=" + space)
    assert {node.namespace for node in pair.nodes} == {f"/{space}/"}
    groups = load("basic_comms/launch/groups.launch", "prefix:=" + space)
    assert {node.namespace for node in groups.nodes} == {f"/{space}1/", f"/{space}2/"}


@pytest.mark.parametrize("text", [text for text in TEXTS if text])
def test_the_bag_is_called_as_typed(text: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setenv("PWD", "/home/o'me 1")
    arguments = ["record:=true", "ns:=lab", "record_prefix:=" + text]
    nodes = load("basic_comms/launch/cw1.launch", *arguments).nodes
    (record,) = [node for node in nodes if node.type == "record"]
    path = text if text.startswith("/") else os.path.join("/home/o'me 1", text)
    said = [word for word in command_line(record) if not word.startswith("__")]
    assert said == ["-o", path, "/lab/signal", "/lab/proc_signal"]


@pytest.mark.parametrize("text", TEXTS)
def test_the_scope_gets_its_texts_as_typed(text: str) -> None:
    (scope,) = load(SCOPE, "fields:=" + text, "address:=" + text, "open_browser:=no").nodes
    said = [word for word in command_line(scope) if not word.startswith("__")]
    address = "--address=" + (text or "127.0.0.1")
    assert said == ["--port", "8080", address, " " + text]


@pytest.mark.parametrize("port, name", [("8080", "scope"), ("8081", "scope_8081")])
def test_the_scope_is_called_after_its_port(port: str, name: str) -> None:
    (scope,) = load(SCOPE, "port:=" + port).nodes
    assert scope.name == name
    words = command_line(scope)
    assert words[:2] == ["--port", port] and "__name:=" + name in words


@pytest.mark.parametrize("port", ["-1", "80.5", "web", "1 --address 0.0.0.0", "true"])
def test_invalid_port_is_refused(port: str) -> None:
    with pytest.raises(RLException) as caught:
        load(SCOPE, "port:=" + port)
    assert f"port is {port.replace('true', 'True')}: must be a whole number" in str(caught.value)


def test_two_plots_have_two_names_and_ports() -> None:
    scopes: List[str] = []
    for space in ("one", "two"):
        nodes = load("basic_comms/launch/cw1.launch", "plot:=on", "ns:=" + space).nodes
        (scope,) = [node for node in nodes if node.type == "scope.py"]
        assert "--next-port" in command_line(scope)
        scopes.append(scope.namespace + scope.name)
    assert scopes == ["/one/scope", "/two/scope"]


def test_a_delay_is_no_command() -> None:
    name = "basic_comms/launch/features/delayed_start.launch"
    (talker,) = [node for node in load(name, "delay:=0").nodes if node.name == "talker"]
    assert command_line(talker) == ["__name:=talker"]
    with pytest.raises(RLException, match="could not convert string to float: '0; echo x'"):
        load(name, "delay:=0; echo x")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("count", [0, 1, 3, 200])
def test_a_count_is_kept_to_its_bound(name: str, count: int) -> None:
    groups = {node.namespace for node in load(name, f"count:={count}").nodes}
    start = "/Group" if "basic_comms" in name else "/group"
    assert groups == {f"{start}{number}/" for number in range(1, count + 1)}


NO_COUNTS = ["1000000000000", "-1", "2.5", "3.0", "two", "True", "[]"]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("count", ["201", *NO_COUNTS])
def test_any_other_count_is_refused(name: str, count: str) -> None:
    with pytest.raises(RLException) as caught:
        load(name, "count:=" + count)
    said = str(caught.value)
    assert f"count is {count}: must be a whole number from 0 to 200; " in said
    assert "fleet.launch" in said


@pytest.mark.parametrize("count", ["5001", *NO_COUNTS])
def test_the_fleet_has_its_bound_too(count: str) -> None:
    assert settings(load(FLEET, "count:=5000"))["/fleet/count"] == 5000
    assert FleetParameters(count=5000).count == 5000
    with pytest.raises(RLException) as caught:
        load(FLEET, "count:=" + count)
    assert f"count is {count}: must be a whole number from 0 to 5000" in str(caught.value)


@pytest.mark.parametrize("name", ROBOTS)
def test_groups_may_begin_at_any_number(name: str) -> None:
    groups = {node.namespace[-3:] for node in load(name, "count:=3", "first:=7").nodes}
    assert groups == {"p7/", "p8/", "p9/"}
    with pytest.raises(RLException, match="first is x: must be a whole number"):
        load(name, "first:=x")


@pytest.mark.parametrize("text", ["abc", "1 # 2", "1:30", "1 2", "nan", "true", "0x10"])
def test_non_numeric_value_is_left_for_the_node_to_refuse(text: str) -> None:
    found = settings(load("basic_comms/launch/cw1.launch", "signal_offset:=" + text))
    offset = found["/signal_generator/offset"]
    assert offset == (text if text != "true" else True)
    with pytest.raises(ParameterError):
        SignalParameters.declared["offset"].coerce(offset)


@pytest.mark.parametrize("text, value", [("1e3", 1000.0), ("-.5", -0.5), ("7", 7.0)])
def test_a_number_may_be_written_in_any_way(text: str, value: float) -> None:
    found = settings(load("basic_comms/launch/cw1.launch", "signal_offset:=" + text))
    offset = found["/signal_generator/offset"]
    assert SignalParameters.declared["offset"].coerce(offset) == value


def test_a_list_stays_one() -> None:
    arguments = ["signal_multisine_amplitudes:=[1.5, 2]", "signal_seed:=3"]
    found = settings(load("basic_comms/launch/cw1.launch", *arguments))
    assert found["/signal_generator/multisine_amplitudes"] == [1.5, 2]
    assert found["/signal_generator/seed"] == 3
    with pytest.raises(RLException, match='param="multisine_amplitudes"'):
        load("basic_comms/launch/cw1.launch", "signal_multisine_amplitudes:=[1")


def test_every_file_is_looked_at() -> None:
    assert len(FILES) > 30 and all((SOURCES / name).is_file() for name in FILES)
